// Nodes of soft bodies that went through a mesh in one step: a ray for each node that moved further, seen from the
// mesh, than contacts at the end of the step would notice.
#include "soft_body_response.h"

#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>

namespace
{
class FirstHit : public btTriangleRaycastCallback
{
  public:
    FirstHit(const btVector3& from, const btVector3& to) : btTriangleRaycastCallback(from, to)
    {
    }

    btScalar reportHit(const btVector3& normal, btScalar fraction, int, int) override
    {
        hit = true;
        hitNormal = normal;
        return fraction;
    }

    bool hit = false;
    btVector3 hitNormal; ///< to the side that the ray came from
};

btScalar MotionOf(const qcSceneSoftBody& soft)
{
    btScalar largest = 0;
    for (size_t i = 0; i < soft.places.size(); i++)
        largest = std::max(largest, soft.places[i].distance2(soft.start[i]));
    return btSqrt(largest);
}

void SweepNodes(qcSceneSoftBody& soft, qcSceneRigid& rigid, const qcSceneMesh& mesh, btScalar reach,
                std::vector<qcSoftConstraint>* constraints)
{
    btTransform from = (rigid.start * mesh.local).inverse();
    btTransform to = (rigid.object->getWorldTransform() * mesh.local).inverse();
    const double weights[3] = {1, 0, 0};
    for (size_t i = 0; i < soft.places.size(); i++)
    {
        btVector3 start = from * soft.start[i], end = to * soft.places[i];
        if (start.distance2(end) <= reach * reach)
            continue;
        FirstHit ray(start, end);
        btVector3 lower = start, upper = start;
        lower.setMin(end);
        upper.setMax(end);
        mesh.shape->processAllTriangles(&ray, lower, upper);
        if (!ray.hit)
            continue;
        const uint32_t vertices[3] = {uint32_t(i), uint32_t(i), uint32_t(i)};
        btVector3 point = mesh.local * (start + (end - start) * ray.m_hitFraction);
        btVector3 normal = rigid.object->getWorldTransform().getBasis() * (mesh.local.getBasis() * ray.hitNormal);
        qcSoftConstraint constraint;
        if (qcMakeMeshConstraint(soft, vertices, weights, rigid, point, normal, reach, &constraint))
            constraints->push_back(constraint);
    }
}
} // namespace

void qcMakeSweptConstraints(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints)
{
    constraints->clear();
    if (scene.meshes.Rigids().empty())
        return;
    BT_PROFILE("qcSoftBodyContact sweep");
    for (qcSceneSoftBody& soft : scene.Bodies())
    {
        btScalar softMotion = MotionOf(soft);
        for (const std::unique_ptr<qcSceneRigid>& rigid : scene.meshes.Rigids())
        {
            if (!qcMayPush(soft, *rigid))
                continue;
            for (const qcSceneMesh& mesh : rigid->meshes)
            {
                btScalar reach = soft.thickness / 2 + mesh.shape->getMargin();
                btScalar motion =
                    qcMotionOf(mesh, rigid->start * mesh.local, rigid->object->getWorldTransform() * mesh.local);
                if (softMotion + motion > reach)
                    SweepNodes(soft, *rigid, mesh, reach, constraints);
            }
        }
    }
}
