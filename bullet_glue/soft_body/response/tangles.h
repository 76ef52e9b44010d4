// Tangles: pairs that penetrate at the start of a step. Contact response exempts them and keeps all others disjoint.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_TANGLES_H
#define QC_GLUE_SOFT_BODY_RESPONSE_TANGLES_H

#include "soft_body/response/intersection_curves.h"

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
    /// True if some triangles of these two bodies penetrate each other.
    bool Contains(uint32_t bodyA, uint32_t bodyB) const
    {
        return m_counts.count({bodyA, bodyB}) != 0;
    }
    /// Marks the vertices of parts that curves cut off, which are on the wrong side of the other surface.
    void MarkParts(const std::vector<qcUntanglement>& untanglements);
    /// True if both triangles are near a tangle of their bodies, and one has a vertex on the wrong side.
    bool MayLeave(qcSoftBodyScene& scene, const qcPair& pair) const;
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
    bool HasVertexIn(const std::vector<Key>& keys, qcSoftBodyScene& scene, uint32_t body, uint32_t triangle,
                     uint32_t other) const;
    static bool Contains(const std::vector<Key>& keys, uint32_t body, uint32_t index, uint32_t other);

    std::vector<Key> m_triangles, m_vertices; ///< sorted
    std::vector<Key> m_wrong;                 ///< sorted: vertices on the wrong side
    std::vector<Key> m_free;                  ///< sorted: vertices of tangles that cut off no part
    std::map<uint32_t, const qcSurfaceGraph*> m_graphs;
    std::map<Slots, size_t> m_counts; ///< of pairs
};

#endif
