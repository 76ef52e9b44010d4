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
    qcBreakingComparison(const qcBreakingWorld& world, qcDevice* device, const qcDetectDef& request)
        : m_world(world), m_comparison(device, request)
    {
    }

    /// Adds all bodies. `record`: a file for a recording of each frame; may be null. False with Message().
    bool Begin(const char* record);
    /// Takes over where the bodies are, and runs the methods that never miss; `compareAll`: and those of the paper.
    bool Run(bool compareAll, qcQueryResults* results);
    /// The PCS of a query of the last Run.
    qcBreakingMarks Marks(qcComparedQuery query) const;
    const std::string& Message() const
    {
        return m_comparison.Message();
    }

  private:
    bool Add(const qcMeshShape& shape, const btTransform& place, qcActivity activity, qcBodyId* id);
    bool Place();

    const qcBreakingWorld& m_world;
    qcQueryComparison m_comparison;
    qcBodyId m_bunny{};
    std::vector<qcBodyId> m_pieces;
    std::vector<bool> m_isStanding;
    std::vector<btTransform> m_places; ///< of the pieces
};

/// Pairs of triangles of two bodies that penetrate, by the exact test; pieces that stand as one are left out.
bool qcCountPenetrating(const qcBreakingWorld& world, size_t* pairs);

#endif
