// Separating planes, solved by projection.
#include "soft_body/response/separating_planes.h"

#include "common/shape_triangles.h"

#include <algorithm>
#include <cmath>

namespace
{
// Bisection steps for the level of a plane: the interval that is left is below the rounding of a float.
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

/// A corner of a triangle, relative to a plane.
struct Corner
{
    btScalar height = 0;      ///< along the plane's normal, away from the plane
    btScalar inverseMass = 0; ///< along the normal; 0: fixed
    btVector3 arm;            ///< of a mesh: from the centre of its object
};

struct Corners
{
    const qcPlaneSide* side;
    btVector3 outward; ///< the plane's normal, away from the plane
    Corner corner[3];
    btScalar lowest = BT_LARGE_FLOAT;       ///< min height
    btScalar lowestPinned = BT_LARGE_FLOAT; ///< min height of fixed corners
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
        made.height = outward.dot(side->soft->positions[vertex]);
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
        made.inverseMass = outward.dot(rigid.DisplacementAt(made.arm, outward));
        return made;
    }

    /// The lowest corner below the floor that can be moved; null: there is none.
    const Corner* Deepest(btScalar floor) const
    {
        const Corner* deepest = nullptr;
        for (int i = 0; i < side->count; i++)
            if (corner[i].inverseMass > 0 && corner[i].height < floor &&
                (deepest == nullptr || corner[i].height < deepest->height))
                deepest = &corner[i];
        return deepest;
    }

    /// The impulse, times the time step, that raises every corner to the floor.
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
                side->soft->positions[side->vertices[i]] += outward * (floor - corner[i].height);
    }
};

/// Divides the missing gap between both sides so that they get the same impulse.
void SolvePlane(const qcSeparationPlane& plane)
{
    Corners above(plane.above, plane.normal), below(plane.below, -plane.normal);
    btScalar missing = plane.gap - above.lowest - below.lowest;
    if (missing <= 0 || (!above.moves && !below.moves))
        return;
    // The share of the upper side. Fixed corners bound it from either end.
    btScalar min = 0, max = 1;
    if (!below.moves)
        min = 1;
    else if (!above.moves)
        max = 0;
    else
    {
        max = std::min(max, (above.lowestPinned - above.lowest) / missing);
        min = std::min(max, std::max(min, 1 - (below.lowestPinned - below.lowest) / missing));
    }
    for (int i = 0; i < s_halvings && min < max; i++)
    {
        btScalar share = (min + max) / 2;
        bool isTooLarge =
            above.Impulse(above.lowest + share * missing) > below.Impulse(below.lowest + (1 - share) * missing);
        (isTooLarge ? max : min) = share;
    }
    above.Raise(above.lowest + min * missing);
    below.Raise(below.lowest + (1 - min) * missing);
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
    scene.GetStartCorners(pair.bodyA, pair.triangleA, above);
    scene.GetStartCorners(pair.bodyB, pair.triangleB, below);
    qcProximity start;
    if (!qcTrianglesWithin(above, below, HUGE_VAL, &start))
        return;
    qcSeparationPlane plane;
    plane.above = SideOf(scene, pair.bodyA, pair.triangleA);
    plane.below = SideOf(scene, pair.bodyB, pair.triangleB);
    plane.normal = qcVectorOf(start.normal);
    // Contacts restore the thickness; a plane only restores a gap, no larger than that of the start.
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
