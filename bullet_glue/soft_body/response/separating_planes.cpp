// Planes between triangles that were apart at the start of a step.
#include "soft_body/response/separating_planes.h"

#include "common/shape_triangles.h"

#include <algorithm>

namespace
{
// Halvings of the interval in which the plane's level lies: what is left is the rounding of a float.
constexpr int s_halvings = 24;

qcPlaneSide SideOf(qcSoftBodyScene& scene, uint32_t slot, uint32_t triangle)
{
    qcPlaneSide side;
    side.soft = scene.Find(slot);
    if (side.soft == nullptr)
        side.mesh = scene.meshes.Find(slot, &side.rigid);
    const uint32_t* corners =
        (side.soft != nullptr ? side.soft->topology.indices.data() : side.mesh->shape->getIndices()) +
        3 * size_t(triangle);
    for (int c = 0; c < 3; c++)
        if (std::find(side.vertices, side.vertices + side.count, corners[c]) == side.vertices + side.count)
            side.vertices[side.count++] = corners[c];
    return side;
}

/// A corner of a triangle as a plane sees it.
struct Corner
{
    btScalar height = 0;      ///< along the plane's normal, away from the plane
    btScalar inverseMass = 0; ///< along the normal; 0: nothing moves it
    btVector3 arm;            ///< of a mesh: from the centre of its body
};

struct Corners
{
    const qcPlaneSide* side;
    btVector3 outward; ///< the plane's normal, towards this side
    Corner corner[3];
    btScalar lowest = BT_LARGE_FLOAT;       ///< height
    btScalar lowestPinned = BT_LARGE_FLOAT; ///< of those that nothing moves
    bool moves = false;

    Corners(const qcPlaneSide& measured, const btVector3& direction) : side(&measured), outward(direction)
    {
        for (int i = 0; i < side->count; i++)
        {
            corner[i] = side->soft != nullptr ? OfSoft(side->vertices[i]) : OfMesh(side->vertices[i]);
            lowest = std::min(lowest, corner[i].height);
            if (corner[i].inverseMass > 0)
                moves = true;
            else
                lowestPinned = std::min(lowestPinned, corner[i].height);
        }
    }

    Corner OfSoft(uint32_t vertex) const
    {
        Corner made;
        made.height = outward.dot(side->soft->places[vertex]);
        made.inverseMass = side->soft->InverseMass(vertex);
        return made;
    }

    Corner OfMesh(uint32_t vertex) const
    {
        const qcSceneRigid& rigid = *side->rigid;
        const btTransform& now = rigid.object->getWorldTransform();
        Corner made;
        btVector3 point = now * (side->mesh->local * side->mesh->shape->getVertices()[vertex]);
        made.arm = point - now.getOrigin();
        made.height = outward.dot(point + rigid.linear + rigid.angular.cross(made.arm));
        made.inverseMass = outward.dot(rigid.Yield(made.arm, outward));
        return made;
    }

    /// The corner of a mesh that lacks most, and that can be moved.
    const Corner* Deepest(btScalar floor) const
    {
        const Corner* deepest = nullptr;
        for (int i = 0; i < side->count; i++)
            if (corner[i].inverseMass > 0 && corner[i].height < floor &&
                (deepest == nullptr || corner[i].height < deepest->height))
                deepest = &corner[i];
        return deepest;
    }

    /// The impulse, times the step, that it takes to raise every corner to the floor.
    btScalar Impulse(btScalar floor) const
    {
        if (side->rigid != nullptr)
        {
            const Corner* deepest = Deepest(floor);
            return deepest != nullptr ? (floor - deepest->height) / deepest->inverseMass : btScalar(0);
        }
        btScalar sum = 0;
        for (int i = 0; i < side->count; i++)
            if (corner[i].inverseMass > 0)
                sum += std::max(btScalar(0), floor - corner[i].height) / corner[i].inverseMass;
        return sum;
    }

    void Raise(btScalar floor) const
    {
        if (side->rigid != nullptr)
        {
            if (const Corner* deepest = Deepest(floor))
                side->rigid->Push(deepest->arm, outward * ((floor - deepest->height) / deepest->inverseMass));
            return;
        }
        for (int i = 0; i < side->count; i++)
            if (corner[i].inverseMass > 0 && corner[i].height < floor)
                side->soft->places[side->vertices[i]] += outward * (floor - corner[i].height);
    }
};

/// Shares what the gap lacks out so that both sides get the same impulse.
void SolvePlane(const qcSeparationPlane& plane)
{
    Corners above(plane.above, plane.normal), below(plane.below, -plane.normal);
    btScalar lack = plane.gap - above.lowest - below.lowest;
    if (lack <= 0 || (!above.moves && !below.moves))
        return;
    // The share of the upper side. What can't be moved bounds it from either end.
    btScalar least = 0, most = 1;
    if (!below.moves)
        least = 1;
    else if (!above.moves)
        most = 0;
    else
    {
        most = std::min(most, (above.lowestPinned - above.lowest) / lack);
        least = std::min(most, std::max(least, 1 - (below.lowestPinned - below.lowest) / lack));
    }
    for (int i = 0; i < s_halvings && least < most; i++)
    {
        btScalar share = (least + most) / 2;
        bool tooMuch = above.Impulse(above.lowest + share * lack) > below.Impulse(below.lowest + (1 - share) * lack);
        (tooMuch ? most : least) = share;
    }
    above.Raise(above.lowest + least * lack);
    below.Raise(below.lowest + (1 - least) * lack);
}

btScalar ThicknessOf(const qcPlaneSide& side)
{
    return side.soft != nullptr ? side.soft->thickness / 2 : side.mesh->shape->getMargin();
}
} // namespace

void qcSeparationPlanes::Clear()
{
    m_planes.clear();
    m_pairs.clear();
}

void qcSeparationPlanes::Add(qcSoftBodyScene& scene, const qcPair& pair)
{
    if (!m_pairs.insert({pair.bodyA, pair.triangleA, pair.bodyB, pair.triangleB}).second)
        return;
    double above[9], below[9];
    scene.StartOf(pair.bodyA, pair.triangleA, above);
    scene.StartOf(pair.bodyB, pair.triangleB, below);
    qcProximity start;
    if (!qcTrianglesWithin(above, below, HUGE_VAL, &start))
        return;
    qcSeparationPlane plane;
    plane.above = SideOf(scene, pair.bodyA, pair.triangleA);
    plane.below = SideOf(scene, pair.bodyB, pair.triangleB);
    plane.normal = qcVectorOf(start.normal);
    // Contacts keep surfaces apart by their thickness; planes only see to it that there is a gap, and no greater one
    // than there was.
    btScalar thickness = ThicknessOf(plane.above) + ThicknessOf(plane.below);
    plane.gap = std::min(btScalar(start.distance), thickness / 4);
    m_planes.push_back(plane);
}

void qcSeparationPlanes::Solve(int sweeps)
{
    for (int i = 0; i < sweeps; i++)
        for (const qcSeparationPlane& plane : m_planes)
            SolvePlane(plane);
}
