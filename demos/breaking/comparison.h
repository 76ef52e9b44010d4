// The bodies of the breaking scene in a comparison of all methods.
#ifndef QC_DEMOS_BREAKING_COMPARISON_H
#define QC_DEMOS_BREAKING_COMPARISON_H

#include "breaking/picture.h"
#include "breaking/world.h"
#include "common/bullet/query_comparison.h"

class qcBreakingComparison
{
  public:
    /// The world must outlive this object.
    qcBreakingComparison(const qcBreakingWorld& world, qcDevice* device, const qcDetectDef& request);
    qcBreakingComparison(const qcBreakingComparison&) = delete;
    qcBreakingComparison& operator=(const qcBreakingComparison&) = delete;

    /// Adds all bodies. `record`: a file for a recording of each frame; may be null. False with Message().
    bool Begin(const char* record);
    /// Takes over where the bodies are, and runs the methods that never miss; `compareAll`: and those of the paper.
    bool Run(bool compareAll, qcQueryResults* results);
    /// The PCS of a query of the last Run.
    qcBreakingMarks Marks(qcComparedQuery query) const
    {
        return MarksOf(m_comparison, query);
    }
    /// The triangles near those of another body, by `sweep` with a margin: what contact is searched on.
    qcBreakingMarks NearMarks() const
    {
        return MarksOf(m_near, qc_querySweep);
    }
    const std::string& Message() const
    {
        return m_comparison.Message().empty() ? m_near.Message() : m_comparison.Message();
    }

  private:
    bool Add(const qcMeshShape& shape, const btTransform& place, qcActivity activity, qcBodyId* id);
    bool Place();
    qcBreakingMarks MarksOf(const qcQueryComparison& comparison, qcComparedQuery query) const;
    static bool MayMeet(void* context, uint32_t slotA, uint32_t slotB);

    const qcBreakingWorld& m_world;
    qcQueryComparison m_comparison;
    qcQueryComparison m_near; ///< the same bodies, for NearMarks
    qcBodyId m_bunny{};
    std::vector<qcBodyId> m_pieces;
    std::vector<uint32_t> m_pieceOfSlot;
    std::vector<bool> m_isStanding;
    std::vector<btTransform> m_places; ///< of the pieces
};

/// Pairs of triangles of two bodies that penetrate, by the exact test; pieces that stand as one are left out.
bool qcCountPenetrating(const qcBreakingWorld& world, size_t* pairs);

#endif
