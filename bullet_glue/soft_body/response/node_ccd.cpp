// Nodes: a ray for each node that moved, relative to the mesh, further than the contact distance at the end of the
// step. Links: continuous collision of a moving edge with edges at rest, in the mesh's frame. They are coplanar at the
// roots of a quadratic in time. Provot: Collision and self-collision handling in cloth model dedicated to design
// garments, 1997, section 3; with both edges moving, as there, it is a cubic.
#include "soft_body/response/node_ccd.h"

#include "common/double_vector.h"
#include "common/object_motion.h"

#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <LinearMath/btAabbUtil2.h>
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
    btVector3 hitNormal; ///< towards the origin of the ray
};

qcDoubleVector Along(const qcDoubleVector& a, const qcDoubleVector& motion, double t)
{
    return {a[0] + t * motion[0], a[1] + t * motion[1], a[2] + t * motion[2]};
}

/// Real roots of c[0] + c[1] t + c[2] t^2, in ascending order. Returns their count.
int FindRoots(const double c[3], double roots[2])
{
    double inner = c[1] * c[1] - 4 * c[2] * c[0];
    if (inner < 0)
        return 0;
    // Without cancellation. A nearly linear quadratic has one root near infinity.
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

/// The first edge of a mesh that a moving rope link crosses.
class FirstCrossing : public btTriangleCallback
{
  public:
    /// Both ends of the link at the start and at the end of the step, in the mesh's frame.
    FirstCrossing(const btVector3 start[2], const btVector3 end[2])
        : m_start(qcDoubleVectorOf(start[0])), m_motion(qcDoubleVectorOf(end[0] - start[0])),
          m_link(qcDoubleVectorOf(start[1] - start[0])),
          m_turn(qcDoubleVectorOf((end[1] - end[0]) - (start[1] - start[0]))), m_ends{qcDoubleVectorOf(start[0]),
                                                                                      qcDoubleVectorOf(start[1]),
                                                                                      qcDoubleVectorOf(end[0]),
                                                                                      qcDoubleVectorOf(end[1])}
    {
    }

    void processTriangle(btVector3* triangle, int, int) override
    {
        if (StaysOnOneSide(triangle))
            return;
        for (int i = 0; i < 3; i++)
            Test(triangle[i], triangle[(i + 1) % 3]);
    }

    double time = 2;           ///< of the crossing, from 0 to 1; above 1: none
    btScalar onLink = 0;       ///< parameter on the link, from its first end
    btVector3 point{0, 0, 0};  ///< on the mesh
    btVector3 normal{0, 0, 0}; ///< unit, perpendicular to both

  private:
    /// True if the link is off the triangle's plane, on one side of it, in the whole step. Then it crosses no edge.
    bool StaysOnOneSide(const btVector3 triangle[3]) const
    {
        const qcDoubleVector corner = qcDoubleVectorOf(triangle[0]),
                             up = qcCrossOf(qcDoubleVectorOf(triangle[1] - triangle[0]),
                                            qcDoubleVectorOf(triangle[2] - triangle[0]));
        double lowest = INFINITY, highest = -INFINITY, size = 0;
        for (const qcDoubleVector& end : m_ends)
        {
            const qcDoubleVector offset = qcMinus(end, corner);
            const double side = qcDotOf(up, offset);
            lowest = std::min(lowest, side);
            highest = std::max(highest, side);
            size = std::max({size, std::abs(offset[0]), std::abs(offset[1]), std::abs(offset[2])});
        }
        const double slack = s_planeSlack * size * std::sqrt(qcDotOf(up, up));
        return lowest > slack || highest < -slack;
    }

    void Test(const btVector3& from, const btVector3& to)
    {
        qcDoubleVector edge = qcDoubleVectorOf(to - from), offset = qcMinus(qcDoubleVectorOf(from), m_start);
        const qcDoubleVector back = {-m_motion[0], -m_motion[1], -m_motion[2]};
        const double c[3] = {qcDotOf(edge, qcCrossOf(offset, m_link)),
                             qcDotOf(edge, qcCrossOf(offset, m_turn)) + qcDotOf(edge, qcCrossOf(back, m_link)),
                             qcDotOf(edge, qcCrossOf(back, m_turn))};
        double roots[2];
        int count = FindRoots(c, roots);
        for (int i = 0; i < count; i++)
            if (roots[i] >= 0 && roots[i] <= 1 && roots[i] < time)
                TestAt(roots[i], from, to, edge, Along(offset, back, roots[i]), Along(m_link, m_turn, roots[i]));
    }

    /// Keeps the crossing at this time if it is between the ends of both.
    void TestAt(double t, const btVector3& from, const btVector3& to, const qcDoubleVector& edge,
                const qcDoubleVector& offset, const qcDoubleVector& link)
    {
        // Ends are nodes and corners: rounding must not open a gap between two adjacent edges.
        const double slack = 1e-6;
        qcDoubleVector n = qcCrossOf(link, edge);
        double n2 = qcDotOf(n, n);
        // Parallel edges touch in their ends: the ray of a node, or another edge there, finds that.
        if (n2 <= 1e-12 * qcDotOf(link, link) * qcDotOf(edge, edge))
            return;
        double linkParameter = qcDotOf(qcCrossOf(offset, edge), n) / n2,
               edgeParameter = qcDotOf(qcCrossOf(offset, link), n) / n2;
        if (linkParameter < -slack || linkParameter > 1 + slack || edgeParameter < -slack || edgeParameter > 1 + slack)
            return;
        time = t;
        onLink = btClamped(btScalar(linkParameter), btScalar(0), btScalar(1));
        point = from + (to - from) * btClamped(btScalar(edgeParameter), btScalar(0), btScalar(1));
        normal = btVector3(btScalar(n[0]), btScalar(n[1]), btScalar(n[2])) / btScalar(std::sqrt(n2));
    }

    // More than the slack of a crossing.
    static constexpr double s_planeSlack = 1e-5;

    const qcDoubleVector m_start, m_motion, m_link, m_turn, m_ends[4];
};

/// The largest motion in the step of a node that collides.
btScalar MaxMotionOf(const qcSceneSoftBody& soft)
{
    btScalar largest = 0;
    for (uint32_t node : soft.topology.nodes)
        largest = std::max(largest, soft.positions[node].distance2(soft.start[node]));
    return btSqrt(largest);
}

/// Appends a constraint for each node that went through the mesh, and moved further than `distance` relative to it.
void AddNodeCcd(qcSceneSoftBody& soft, qcSceneRigid& rigid, const qcSceneMesh& mesh, btScalar distance,
                std::vector<qcSoftConstraint>* constraints)
{
    btTransform from = (rigid.start * mesh.local).inverse();
    btTransform to = (rigid.object->getWorldTransform() * mesh.local).inverse();
    const double weights[3] = {1, 0, 0};
    for (uint32_t node : soft.topology.nodes)
    {
        btVector3 start = from * soft.start[node], end = to * soft.positions[node];
        const uint32_t vertices[3] = {node, node, node};
        if (start.distance2(end) <= distance * distance || soft.IsAnchored(vertices, rigid.object))
            continue;
        FirstHit ray(start, end);
        btVector3 lower = start, upper = start;
        lower.setMin(end);
        upper.setMax(end);
        mesh.shape->processAllTriangles(&ray, lower, upper);
        if (!ray.hit)
            continue;
        btVector3 point = mesh.local * (start + (end - start) * ray.m_hitFraction);
        btVector3 normal = rigid.object->getWorldTransform().getBasis() * (mesh.local.getBasis() * ray.hitNormal);
        qcSoftConstraint constraint;
        if (qcMakeMeshConstraint(soft, vertices, weights, rigid, {point, point}, normal, distance, &constraint))
            constraints->push_back(constraint);
    }
}

/// Appends constraints for the rope links that went through the mesh.
void AddLinksCcd(qcSceneSoftBody& soft, qcSceneRigid& rigid, const qcSceneMesh& mesh,
                 std::vector<qcSoftConstraint>* constraints)
{
    const qcSoftTopology& topology = soft.topology;
    const btTransform from = (rigid.start * mesh.local).inverse(), now = rigid.object->getWorldTransform();
    const btTransform to = (now * mesh.local).inverse();
    for (size_t i = topology.faceCount; i < topology.faceCount + topology.ropeCount; i++)
    {
        const uint32_t vertices[3] = {topology.indices[3 * i], topology.indices[3 * i + 1],
                                      topology.indices[3 * i + 1]};
        const btVector3 start[2] = {from * soft.start[vertices[0]], from * soft.start[vertices[1]]};
        const btVector3 end[2] = {to * soft.positions[vertices[0]], to * soft.positions[vertices[1]]};
        btVector3 lower = start[0], upper = start[0];
        for (const btVector3& p : {start[1], end[0], end[1]})
        {
            lower.setMin(p);
            upper.setMax(p);
        }
        if (soft.IsAnchored(vertices, rigid.object))
            continue;
        FirstCrossing crossing(start, end);
        mesh.shape->processAllTriangles(&crossing, lower, upper);
        if (crossing.time > 1)
            continue;
        const double weights[3] = {1 - double(crossing.onLink), double(crossing.onLink), 0};
        qcSoftConstraint constraint;
        const btVector3 point = mesh.local * crossing.point;
        if (qcMakeMeshConstraint(soft, vertices, weights, rigid, {point, point},
                                 now.getBasis() * (mesh.local.getBasis() * crossing.normal),
                                 mesh.ContactDistance(soft.thickness), &constraint))
            constraints->push_back(constraint);
    }
}

/// A mesh, and the box of its motion.
struct MovingMesh
{
    qcSceneRigid* rigid;
    const qcSceneMesh* mesh;
    btVector3 box[2];
};

std::vector<MovingMesh> MovingMeshes(const qcSoftBodyScene& scene)
{
    std::vector<MovingMesh> meshes;
    for (const std::unique_ptr<qcSceneRigid>& rigid : scene.meshes.Rigids())
        for (const qcSceneMesh& mesh : rigid->meshes)
        {
            // Rays pass a mesh that deforms by the wrong way: planes alone hold what it meets.
            if (mesh.Deforms())
                continue;
            meshes.push_back({rigid.get(), &mesh, {}});
            rigid->FindMotionBox(mesh, meshes.back().box);
        }
    return meshes;
}

/// Calls function(mesh) for each mesh that the soft body may pass and that responds to it. Where the boxes of both
/// motions are apart, they pass each other nowhere.
template <typename Function>
void ForEachNear(const qcSceneSoftBody& soft, const std::vector<MovingMesh>& meshes, const Function& function)
{
    btVector3 box[2];
    const bool isFinite = soft.FindMotionBox(0, box);
    for (const MovingMesh& moving : meshes)
        if ((!isFinite || TestAabbAgainstAabb2(box[0], box[1], moving.box[0], moving.box[1])) &&
            qcHasResponse(soft, *moving.rigid, *moving.mesh))
            function(moving);
}
} // namespace

void qcAddLinkCcdConstraints(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints)
{
    const std::vector<MovingMesh> meshes = MovingMeshes(scene);
    for (qcSceneSoftBody& soft : scene.Bodies())
        if (soft.topology.ropeCount > 0 && soft.hasPartner)
            ForEachNear(soft, meshes,
                        [&](const MovingMesh& moving) { AddLinksCcd(soft, *moving.rigid, *moving.mesh, constraints); });
}

void qcMakeNodeCcdConstraints(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints)
{
    constraints->clear();
    if (scene.meshes.Rigids().empty())
        return;
    BT_PROFILE("qcSoftBodyContact sweep");
    const std::vector<MovingMesh> meshes = MovingMeshes(scene);
    for (qcSceneSoftBody& soft : scene.Bodies())
    {
        if (!soft.hasPartner)
            continue;
        const btScalar softMotion = MaxMotionOf(soft);
        ForEachNear(soft, meshes,
                    [&](const MovingMesh& moving)
                    {
                        qcSceneRigid& rigid = *moving.rigid;
                        const qcSceneMesh& mesh = *moving.mesh;
                        btScalar distance = mesh.ContactDistance(soft.thickness);
                        btScalar motion = qcMaxDisplacement(mesh.shape, rigid.start * mesh.local,
                                                            rigid.object->getWorldTransform() * mesh.local);
                        if (softMotion + motion > distance)
                            AddNodeCcd(soft, rigid, mesh, distance, constraints);
                    });
    }
}
