// Separating planes between triangles that are disjoint at the start of a step and not proven apart over it. The normal
// is the direction between their closest points at the start. Both triangles are pushed out of the gap that they had
// along it, by equal and opposite momentum, with Coulomb friction: the response is the same in any frame of reference.
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

/// A pair that is not proven apart over the step.
struct qcUnprovenPair
{
    qcPair pair;
    btVector3 normal;  ///< of the start: from the closest point of B to that of A; of least penetration if they touch
    btScalar distance; ///< at the start; 0 too where no direction is proven to separate since they nearly touch
};

/// `start`: the proximity of the pair at the start of the step.
qcUnprovenPair qcMakeUnproven(qcSoftBodyScene& scene, const qcPair& pair, const qcProximity& start);

/// Classifies the motion of a pair that touches at the start, along its direction of smallest penetration.
enum class qcTouchingMotion
{
    Proven,   ///< a direction separates at the end, and up to rounding at the start
    Unproven, ///< it separates at the start only
    Entangled ///< it doesn't separate at the start: no plane can keep the pair apart
};

/// `isInZone`: the pair may have moved as one rigid body, and is proven unless it penetrates at the end.
qcTouchingMotion qcClassifyTouching(qcSoftBodyScene& scene, const qcUnprovenPair& pair, bool isInZone);

struct qcSeparatingPlane
{
    qcPlaneSide above, below;
    btVector3 normal; ///< unit, from below to above
    btScalar gap;     ///< required distance of the two triangles along the normal
    btScalar friction;
};

class qcSeparatingPlanes
{
  public:
    void Clear();
    /// Adds a plane for a pair, unless the pair has one. `widening`: by which the gap of the start is to grow, as a
    /// share of the thickness.
    void Add(qcSoftBodyScene& scene, const qcUnprovenPair& unproven, btScalar widening = 0);
    /// True if one of the planes pushes a guided object: sweeps converge slowly, since it may weigh far more than
    /// nodes.
    bool HasGuided() const;
    /// Gauss-Seidel sweeps over all planes, at most. Moves positions of nodes; meshes move with the next Commit.
    /// `movesAll`: false: guided meshes alone.
    void Solve(int sweeps, bool movesAll = true);
    size_t Count() const
    {
        return m_planes.size();
    }
    const std::vector<qcSeparatingPlane>& Planes() const
    {
        return m_planes;
    }

  private:
    std::vector<qcSeparatingPlane> m_planes;
    std::set<std::array<uint32_t, 4>> m_pairs; ///< those that have a plane
};

#endif
