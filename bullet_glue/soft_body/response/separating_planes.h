// Separating planes between triangles that are disjoint at the start of a step and penetrate at its end. The normal is
// the direction between their closest points at the start. Both triangles are pushed out of the gap that they had along
// it, by equal and opposite momentum: the response is the same in any frame of reference.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_SEPARATING_PLANES_H
#define QC_GLUE_SOFT_BODY_RESPONSE_SEPARATING_PLANES_H

#include "soft_body/scene/soft_scene.h"

#include <array>
#include <set>

/// The triangle on one side of a plane, of a soft body or a mesh.
struct qcPlaneSide
{
    qcSceneSoftBody* soft = nullptr;
    qcSceneRigid* rigid = nullptr; ///< null for a soft body
    const qcSceneMesh* mesh = nullptr;
    uint32_t vertices[3] = {0, 0, 0}; ///< the first `count`, no two equal
    int count = 0;
};

struct qcSeparationPlane
{
    qcPlaneSide above, below;
    btVector3 normal; ///< unit, from below to above
    btScalar gap;     ///< required distance of the two triangles along the normal
};

class qcSeparationPlanes
{
  public:
    void Clear();
    /// Adds a plane for a pair that penetrates now and was disjoint at the start of the step, unless the pair has one.
    void Add(qcSoftBodyScene& scene, const qcPair& pair);
    /// Gauss-Seidel sweeps over all planes. Moves positions of nodes; meshes move with the next Commit.
    void Solve(int sweeps);
    size_t Count() const
    {
        return m_planes.size();
    }

  private:
    std::vector<qcSeparationPlane> m_planes;
    std::set<std::array<uint32_t, 4>> m_pairs; ///< those that have a plane
};

#endif
