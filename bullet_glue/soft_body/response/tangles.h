// Tangles: pairs that penetrate at the start of a step. Contact response exempts them and keeps all others disjoint.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_TANGLES_H
#define QC_GLUE_SOFT_BODY_RESPONSE_TANGLES_H

#include "soft_body/scene/soft_scene.h"

#include <array>
#include <map>
#include <vector>

/// A triangle is tangled with a body (another one or its own) if it penetrates that at the start of the step; so are
/// its vertices. Bodies are slots of the scene.
class qcSoftTangles
{
  public:
    /// Reads the tangles from the result of a query at the positions of the start.
    void Read(qcSoftBodyScene& scene, const qcResult& result);

    bool IsEmpty() const
    {
        return m_triangles.empty();
    }
    /// Moves the exempt pairs from `pairs`, indices of the result's pairs, to `exempt`. A pair of two tangled triangles
    /// is exempt. While two bodies have no more pairs than at the start, a pair of two triangles near the tangle is
    /// exempt too: a soft body's triangle with a tangled vertex, or a tangled triangle of a mesh. So a tangle may move
    /// but not grow.
    void MoveExempt(qcSoftBodyScene& scene, const qcResult& result, std::vector<size_t>* pairs,
                    std::vector<size_t>* exempt) const;
    void Clear();
    /// True if both triangles are near a tangle of their bodies: a soft body's triangle with a tangled vertex, or a
    /// tangled triangle of a mesh.
    bool IsNear(qcSoftBodyScene& scene, const qcPair& pair) const;
    /// True if the result has more pairs of these two bodies than the start of the step.
    bool HasGrown(const qcResult& result, uint32_t bodyA, uint32_t bodyB) const;
    /// True if all vertices of one side are tangled with the other side's body: the side on which they belong is
    /// unknown.
    bool IsExempt(const qcContact& contact) const;

  private:
    using Key = std::array<uint32_t, 3>; ///< slot, index in the body, slot of the other body
    using Slots = std::pair<uint32_t, uint32_t>;

    bool IsNearTangle(qcSoftBodyScene& scene, uint32_t body, uint32_t triangle, uint32_t other) const;
    static bool Contains(const std::vector<Key>& keys, uint32_t body, uint32_t index, uint32_t other);

    std::vector<Key> m_triangles, m_vertices; ///< sorted
    std::map<Slots, size_t> m_counts;         ///< of pairs
};

#endif
