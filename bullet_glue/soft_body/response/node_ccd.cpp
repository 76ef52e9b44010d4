// Nodes and rope links of soft bodies that went through a mesh in one step.
//
// Nodes: a ray for each node that moved further, seen from the mesh, than contacts at the end of the step would notice.
// Links: continuous collision of two edges, the one moving in the mesh's frame, the other at rest there. They are
// coplanar where a quadratic in time is 0: Provot: Collision and self-collision handling in cloth model dedicated to
// design garments, 1997, section 3, for whom both edges move and it is a cubic.
#include "soft_body/response/position_constraints.h"

#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cmath>

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

struct Vector
{
    double x, y, z;
};

Vector VectorOf(const btVector3& v)
{
    return {double(v.x()), double(v.y()), double(v.z())};
}

Vector Minus(const Vector& a, const Vector& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}

Vector Along(const Vector& a, const Vector& motion, double t)
{
    return {a.x + t * motion.x, a.y + t * motion.y, a.z + t * motion.z};
}

Vector Cross(const Vector& a, const Vector& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

double Dot(const Vector& a, const Vector& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Real roots of c[0] + c[1] t + c[2] t^2, in order.
int FindRoots(const double c[3], double roots[2])
{
    double inner = c[1] * c[1] - 4 * c[2] * c[0];
    if (inner < 0)
        return 0;
    // Without cancellation; a quadratic that is nearly linear has one of its roots nearly at infinity.
    double q = -(c[1] + (c[1] < 0 ? -1 : 1) * std::sqrt(inner)) / 2;
    int count = 0;
    if (c[2] != 0)
        roots[count++] = q / c[2];
    if (q != 0)
        roots[count++] = c[0] / q;
    if (count == 2 && roots[1] < roots[0])
        std::swap(roots[0], roots[1]);
    return count;
}

/// A rope link that moves from one place to another, and the first edge of the mesh that it crosses on its way.
class FirstCrossing : public btTriangleCallback
{
  public:
    /// In the mesh's frame: both ends at the start and at the end of the step.
    FirstCrossing(const btVector3 start[2], const btVector3 end[2])
        : m_start(VectorOf(start[0])), m_motion(VectorOf(end[0] - start[0])), m_link(VectorOf(start[1] - start[0])),
          m_turn(VectorOf((end[1] - end[0]) - (start[1] - start[0])))
    {
    }

    void processTriangle(btVector3* triangle, int, int) override
    {
        for (int i = 0; i < 3; i++)
            Test(triangle[i], triangle[(i + 1) % 3]);
    }

    double time = 2;           ///< of the crossing, from 0 to 1; above 1: none
    btScalar onLink = 0;       ///< where on the link, from its first end
    btVector3 point{0, 0, 0};  ///< where on the mesh
    btVector3 normal{0, 0, 0}; ///< unit, at right angles to both

  private:
    void Test(const btVector3& from, const btVector3& to)
    {
        Vector edge = VectorOf(to - from), offset = Minus(VectorOf(from), m_start);
        const Vector back = {-m_motion.x, -m_motion.y, -m_motion.z};
        const double c[3] = {Dot(edge, Cross(offset, m_link)),
                             Dot(edge, Cross(offset, m_turn)) + Dot(edge, Cross(back, m_link)),
                             Dot(edge, Cross(back, m_turn))};
        double roots[2];
        int count = FindRoots(c, roots);
        for (int i = 0; i < count; i++)
            if (roots[i] >= 0 && roots[i] <= 1 && roots[i] < time)
                TestAt(roots[i], from, to, edge, Along(offset, back, roots[i]), Along(m_link, m_turn, roots[i]));
    }

    /// Do they meet, at this time, between their ends?
    void TestAt(double t, const btVector3& from, const btVector3& to, const Vector& edge, const Vector& offset,
                const Vector& link)
    {
        // Ends are nodes and corners, which rounding must not let slip between an edge and the next.
        const double slack = 1e-6;
        Vector n = Cross(link, edge);
        double n2 = Dot(n, n);
        // Parallel edges touch in their ends: the ray of a node, or another edge there, finds it.
        if (n2 <= 1e-12 * Dot(link, link) * Dot(edge, edge))
            return;
        double mine = Dot(Cross(offset, edge), n) / n2, others = Dot(Cross(offset, link), n) / n2;
        if (mine < -slack || mine > 1 + slack || others < -slack || others > 1 + slack)
            return;
        time = t;
        onLink = btClamped(btScalar(mine), btScalar(0), btScalar(1));
        point = from + (to - from) * btClamped(btScalar(others), btScalar(0), btScalar(1));
        normal = btVector3(btScalar(n.x), btScalar(n.y), btScalar(n.z)) / btScalar(std::sqrt(n2));
    }

    const Vector m_start, m_motion, m_link, m_turn;
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

void SweepLink(qcSceneSoftBody& soft, const uint32_t ends[2], qcSceneRigid& rigid, const qcSceneMesh& mesh,
               std::vector<qcSoftConstraint>* constraints)
{
    btTransform from = (rigid.start * mesh.local).inverse(), now = rigid.object->getWorldTransform();
    btTransform to = (now * mesh.local).inverse();
    const btVector3 start[2] = {from * soft.start[ends[0]], from * soft.start[ends[1]]};
    const btVector3 end[2] = {to * soft.places[ends[0]], to * soft.places[ends[1]]};
    btVector3 lower = start[0], upper = start[0];
    for (const btVector3& p : {start[1], end[0], end[1]})
    {
        lower.setMin(p);
        upper.setMax(p);
    }
    FirstCrossing crossing(start, end);
    mesh.shape->processAllTriangles(&crossing, lower, upper);
    if (crossing.time > 1)
        return;
    const uint32_t vertices[3] = {ends[0], ends[1], ends[1]};
    const double weights[3] = {1 - double(crossing.onLink), double(crossing.onLink), 0};
    qcSoftConstraint constraint;
    if (qcMakeMeshConstraint(soft, vertices, weights, rigid, mesh.local * crossing.point,
                             now.getBasis() * (mesh.local.getBasis() * crossing.normal),
                             soft.thickness / 2 + mesh.shape->getMargin(), &constraint))
        constraints->push_back(constraint);
}
} // namespace

void qcAddSweptLinks(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints)
{
    for (qcSceneSoftBody& soft : scene.Bodies())
        for (const std::unique_ptr<qcSceneRigid>& rigid : scene.meshes.Rigids())
        {
            const qcSoftTopology& topology = soft.topology;
            if (topology.ropeCount == 0 || !qcMayPush(soft, *rigid))
                continue;
            for (const qcSceneMesh& mesh : rigid->meshes)
                for (size_t i = topology.faceCount; i < topology.faceCount + topology.ropeCount; i++)
                    SweepLink(soft, &topology.indices[3 * i], *rigid, mesh, constraints);
        }
}

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
