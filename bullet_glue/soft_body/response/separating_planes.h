// Planes between triangles that were apart at the start of a step and penetrate at its end.
//
// The plane's normal is the direction between the closest points of the start. Both triangles are pushed out of the gap
// that they had along it: by equal and opposite momentum, and in any frame of reference alike.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_SEPARATING_PLANES_H
#define QC_GLUE_SOFT_BODY_RESPONSE_SEPARATING_PLANES_H

#include "soft_body/response/tangles.h"

#include <cmath>

#include <set>

/// One triangle beside a plane: of a soft body or of a mesh.
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
    btScalar gap;     ///< least distance of the two triangles along the normal
};

class qcSeparationPlanes
{
  public:
    void Clear();
    /// Adds a plane for a pair that penetrates now and did not at the start of the step, unless the pair has one.
    void Add(qcSoftBodyScene& scene, const qcPair& pair);
    /// Gauss-Seidel sweeps over all planes. Moves places of nodes; meshes move with the next Commit.
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
