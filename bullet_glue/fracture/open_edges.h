// Net counts of half-edges, and the loops that open edges form.
#ifndef QC_GLUE_FRACTURE_OPEN_EDGES_H
#define QC_GLUE_FRACTURE_OPEN_EDGES_H

#include "common/hash_table.h"

/// A directed edge of a face, counterclockwise as seen from outside.
struct qcHalfEdge
{
    uint32_t from, to;
};

/// Loops of points, one after another.
struct qcClipLoops
{
    std::vector<uint32_t> points;
    std::vector<size_t> ends; ///< end of each loop in the points

    size_t Begin(size_t loop) const
    {
        return loop == 0 ? 0 : ends[loop - 1];
    }
};

/// For each edge, its half-edges in one direction less those in the other. A closed surface has zero everywhere.
class qcEdgeCounts
{
  public:
    /// Empties the counts, and makes room for a number of edges; more make it grow.
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

    /// Chains the surplus half-edges into loops; `reversed`: in the opposite direction, as the missing half-edges. The
    /// loops depend on the counts alone, not on the order in which edges were added.
    void FindLoops(bool reversed, qcClipLoops* loops);

  private:
    static uint64_t KeyOf(uint32_t a, uint32_t b)
    {
        return uint64_t(std::min(a, b)) << 32 | std::max(a, b);
    }

    qcHashTable<uint64_t, int> m_counts; ///< half-edges from the lower index to the higher one less those back
    std::vector<uint64_t> m_halfEdges;   ///< from << 32 | to, sorted
    std::vector<uint32_t> m_next;        ///< by point: the first half-edge from there that is in no loop yet
};

#endif
