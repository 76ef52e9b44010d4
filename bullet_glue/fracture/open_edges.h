// Counts how triangles pass their edges, and chains those that are open into loops.
#ifndef QC_GLUE_FRACTURE_OPEN_EDGES_H
#define QC_GLUE_FRACTURE_OPEN_EDGES_H

#include "common/hash_table.h"

/// An edge as a face passes it.
struct qcClipArrow
{
    uint32_t from, to;
};

/// Loops of points, one after another.
struct qcClipLoops
{
    std::vector<uint32_t> points;
    std::vector<size_t> ends; ///< of each loop, in the points

    size_t Begin(size_t loop) const
    {
        return loop == 0 ? 0 : ends[loop - 1];
    }
};

class qcClipEdges
{
  public:
    /// As qcHashTable::Clear.
    void Clear(size_t expected)
    {
        m_counts.Clear(expected);
    }

    void Add(uint32_t from, uint32_t to)
    {
        if (from != to)
            m_counts.FindOrAdd(KeyOf(from, to), 0) += from < to ? 1 : -1;
    }

    void Add(const std::array<uint32_t, 3>& corners)
    {
        Add(corners[0], corners[1]);
        Add(corners[1], corners[2]);
        Add(corners[2], corners[0]);
    }

    /// Loops of edges that are passed more often one way than the other: `turned`, in the way that is missing. They
    /// depend on the counts alone, not on the order in which edges came.
    void FindLoops(bool turned, qcClipLoops* loops);

  private:
    static uint64_t KeyOf(uint32_t a, uint32_t b)
    {
        return uint64_t(std::min(a, b)) << 32 | std::max(a, b);
    }

    qcHashTable<uint64_t, int> m_counts; ///< how much more often from the lower index to the higher one than back
    std::vector<uint64_t> m_arrows;      ///< from, to: in order
    std::vector<uint32_t> m_next;        ///< by point, the first of its arrows that no loop has passed
};

#endif
