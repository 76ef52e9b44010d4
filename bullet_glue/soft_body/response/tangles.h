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
    void Clear();
    /// True if some triangles of these two bodies penetrate each other.
    bool Contains(uint32_t bodyA, uint32_t bodyB) const
    {
        return m_counts.count({bodyA, bodyB}) != 0;
    }
    /// Likewise in either order.
    bool AreTangled(uint32_t bodyA, uint32_t bodyB) const
    {
        return Contains(bodyA, bodyB) || Contains(bodyB, bodyA);
    }
    /// True if triangles of these two penetrate each other.
    bool AreTangled(const qcSceneSoftBody& soft, const qcSceneRigid& rigid) const;
    /// Marks the vertices that leave the other surface: those in parts that curves cut off, and all of curves that
    /// divide no surface. Refers to the curves.
    void MarkParts(const std::vector<qcUntanglement>& untanglements);
    /// True if both triangles have tangled vertices, and one has a vertex that leaves. Other triangles near the tangle
    /// are on the right side already and stay there, so a part that leaves does not come back.
    bool MayLeave(qcSoftBodyScene& scene, const qcPair& pair) const;
    /// True if both triangles are near a tangle that isn't worked apart: a soft body's triangle with a tangled vertex,
    /// or a tangled triangle of a mesh. Such a pair is exempt while the tangle hasn't grown.
    bool IsKept(qcSoftBodyScene& scene, const qcPair& pair) const;
    /// True if the result has more pairs of these two bodies than the start of the step.
    bool HasGrown(const qcResult& result, uint32_t bodyA, uint32_t bodyB) const;
    /// True if the side on which the contact's vertices belong is unknown: one of them leaves, or all vertices of one
    /// side are in tangles that aren't worked apart.
    bool IsExempt(const qcContact& contact) const;

  private:
    using Key = std::array<uint32_t, 3>; ///< slot, index in the body, slot of the other body
    using Slots = std::pair<uint32_t, uint32_t>;

    bool HasVertexIn(const std::vector<Key>& keys, qcSoftBodyScene& scene, uint32_t body, uint32_t triangle,
                     uint32_t other) const;
    static bool Contains(const std::vector<Key>& keys, uint32_t body, uint32_t index, uint32_t other);

    //  Sorted. Vertices of meshes are in the second only after MarkParts.
    std::vector<Key> m_triangles, m_vertices;
    std::vector<Key> m_leaving;                         ///< vertices
    std::vector<Key> m_leavingRopes;                    ///< vertices of rope links that cross something, and of that
    std::vector<Key> m_kept;                            ///< vertices whose tangles must not grow
    std::map<uint32_t, const qcSurfaceGraph*> m_graphs; ///< of slots with curves
    std::map<Slots, size_t> m_counts;                   ///< of pairs
};

#endif
