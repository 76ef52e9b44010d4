// Separating planes, solved by projection.
#include "soft_body/response/separating_planes.h"

#include "common/shape_triangles.h"

#include <algorithm>
#include <cmath>

namespace
{
// Bisection steps for the level of a plane: the interval that is left is below the rounding of a float.
constexpr int s_halvings = 24;
// Triangles at a smaller distance, relative to their coordinates, nearly touch: certificates can't tell their distance
// from rounding.
constexpr double s_minDistance = 1e-12;
// The gap of triangles that touch at the start, as a share of the thickness: a direction that is not strict at the
// start has to be at the end.
constexpr btScalar s_touchingGap = btScalar(1e-3);
// The least rise of a guided body with friction, as a share of that without.
constexpr btScalar s_minRise = btScalar(0.2);

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

/// The present position of a vertex of a mesh, with what its object moves by at the next Commit. `arm`: from the centre
/// of the object, without that.
btVector3 EndOfMesh(const qcPlaneSide& side, uint32_t vertex, btVector3* arm)
{
    const qcSceneRigid& rigid = *side.rigid;
    const btVector3 end = rigid.PresentOf(*side.mesh, vertex);
    *arm = end - rigid.object->getWorldTransform().getOrigin();
    return end + rigid.Pushed().At(*arm);
}

/// The least height of a triangle's corners above an origin.
btScalar LowestOf(const qcPlaneSide& side, const btVector3& outward, const btVector3& origin)
{
    btScalar lowest = BT_LARGE_FLOAT;
    for (int i = 0; i < side.count; i++)
    {
        btVector3 arm;
        const btVector3 end =
            side.soft != nullptr ? side.soft->positions[side.vertices[i]] : EndOfMesh(side, side.vertices[i], &arm);
        lowest = std::min(lowest, outward.dot(end - origin));
    }
    return lowest;
}

/// A corner of a triangle, relative to a plane.
struct Corner
{
    btVector3 start, end;         ///< positions at the start of the step and at present
    btVector3 motion;             ///< in the step so far
    btScalar height = 0;          ///< along the plane's normal, away from the plane
    btScalar startHeight = 0;     ///< at the start of the step
    btScalar inverseMass = 0;     ///< along the normal; 0: fixed
    btVector3 arm;                ///< of a mesh, or of a tied node: from the centre of its object
    qcSceneRigid* tied = nullptr; ///< the body that a node moves with
};

struct Corners
{
    const qcPlaneSide* side;
    btVector3 outward; ///< the plane's normal, away from the plane
    btVector3 origin;  ///< of heights, near the triangle: heights are small, and little is rounded
    Corner corner[3];
    btScalar lowest = BT_LARGE_FLOAT;       ///< min height
    btScalar lowestPinned = BT_LARGE_FLOAT; ///< min height of fixed corners
    bool moves = false;

    Corners(const qcPlaneSide& measured, const btVector3& direction, const btVector3& zero, bool movesAll = true)
        : side(&measured), outward(direction), origin(zero)
    {
        for (int i = 0; i < side->count; i++)
        {
            corner[i] = side->soft != nullptr ? OfSoft(side->vertices[i]) : OfMesh(side->vertices[i]);
            if (!movesAll && !IsGuided())
                corner[i].inverseMass = 0;
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
        made.start = side->soft->start[vertex];
        made.end = side->soft->positions[vertex];
        made.motion = side->soft->MotionOf(vertex, made.start);
        made.height = outward.dot(made.end - origin);
        made.startHeight = outward.dot(made.start - origin);
        made.inverseMass = side->soft->InverseMass(vertex);
        made.tied = side->soft->TiedTo(vertex);
        if (made.tied != nullptr)
        {
            made.arm = made.end - made.tied->object->getWorldTransform().getOrigin() - made.tied->pushed.linear;
            made.inverseMass = outward.dot(made.tied->DisplacementAt(made.arm, outward));
        }
        return made;
    }

    Corner OfMesh(uint32_t vertex) const
    {
        const qcSceneRigid& rigid = *side->rigid;
        Corner made;
        made.start = rigid.StartOf(*side->mesh, vertex);
        made.end = EndOfMesh(*side, vertex, &made.arm);
        made.motion = made.end - made.start + rigid.ConveyedAt(made.end, outward);
        made.height = outward.dot(made.end - origin);
        made.startHeight = outward.dot(made.start - origin);
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

    bool IsGuided() const
    {
        return side->rigid != nullptr && side->rigid->isGuided;
    }

    /// Has inverse masses include what friction raises a guided body by: it moves that along its way, and so off the
    /// plane or into it. False: it would raise the body by far less than the push alone, and there can be none.
    bool TakeFriction(const btVector3& sliding)
    {
        if (!IsGuided())
            return true;
        btScalar along[3] = {0, 0, 0};
        for (int i = 0; i < side->count; i++)
        {
            along[i] = outward.dot(side->rigid->DisplacementAt(corner[i].arm, outward + sliding));
            if (corner[i].inverseMass > 0 && along[i] < s_minRise * corner[i].inverseMass)
                return false;
        }
        for (int i = 0; i < side->count; i++)
            corner[i].inverseMass = corner[i].inverseMass > 0 ? along[i] : btScalar(0);
        return true;
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

    /// The motion of the corners that the floor raises, weighted by impulses, or their mean if none can move; `raised`:
    /// likewise, the distance.
    btVector3 MeanMotion(btScalar floor, btScalar* raised) const
    {
        btVector3 sum(0, 0, 0), all(0, 0, 0);
        btScalar weights = 0, distances = 0;
        for (int i = 0; i < side->count; i++)
        {
            btScalar distance = std::max(btScalar(0), floor - corner[i].height);
            btScalar weight = corner[i].inverseMass > 0 ? distance / corner[i].inverseMass : btScalar(0);
            sum += corner[i].motion * weight;
            distances += distance * weight;
            weights += weight;
            all += corner[i].motion / btScalar(side->count);
        }
        *raised = weights > 0 ? distances / weights : btScalar(0);
        return weights > 0 ? sum / weights : all;
    }

    /// Raises all corners to the floor; `sliding`: the motion against friction, for each unit of distance raised.
    void Raise(btScalar floor, const btVector3& sliding) const
    {
        if (side->rigid != nullptr)
        {
            if (const Corner* deepest = Deepest(floor))
                RaiseRigid(side->rigid, *deepest, floor - deepest->height, sliding);
            return;
        }
        for (int i = 0; i < side->count; i++)
        {
            btVector3& position = side->soft->positions[side->vertices[i]];
            if (!(corner[i].inverseMass > 0 && corner[i].height < floor))
                continue;
            if (corner[i].tied == nullptr)
                position += (outward + sliding) * (floor - corner[i].height);
            // One body raises all of its corners.
            else if (const btScalar missing = floor - outward.dot(position - origin); missing > 0)
                RaiseRigid(corner[i].tied, corner[i], missing, sliding);
        }
    }

    void RaiseRigid(qcSceneRigid* rigid, const Corner& at, btScalar distance, const btVector3& sliding) const
    {
        const btScalar impulse = distance / at.inverseMass;
        rigid->Push(at.arm, (outward + sliding) * impulse);
        // Normals of single pairs are not those of the surface: with their torque a ball in a cloth was spun up without
        // any friction, and threw the cloth about. Contact turns bodies.
        if (rigid->body != nullptr)
            rigid->recovered.angular += rigid->DisplacementBy(at.arm, outward * impulse).angular;
    }
};

/// The displacement of the upper side by friction, for each unit of distance raised: at most the coefficient, and not
/// more than stops the sliding. The lower side has the opposite one, so impulses stay equal and opposite.
btVector3 FindFriction(const qcSeparatingPlane& plane, const Corners& above, btScalar floorAbove, const Corners& below,
                       btScalar floorBelow)
{
    btScalar raisedAbove, raisedBelow;
    btVector3 motion = above.MeanMotion(floorAbove, &raisedAbove) - below.MeanMotion(floorBelow, &raisedBelow);
    btVector3 sliding = motion - plane.normal * plane.normal.dot(motion);
    btScalar length = sliding.length(), raised = raisedAbove + raisedBelow;
    if (length <= SIMD_EPSILON || raised <= 0)
        return btVector3(0, 0, 0);
    return sliding * (-std::min(plane.friction / length, 1 / raised));
}

/// The share of the missing gap by which the upper side rises, so that both get the same impulse.
btScalar FindShare(const Corners& above, const Corners& below, btScalar missing)
{
    // Fixed corners bound it from either end.
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
    return min;
}

/// Pushes both sides out of the missing gap; `movesAll`: false: guided objects alone. False: it was not missing, or no
/// side can move.
bool SolvePlane(const qcSeparatingPlane& plane, bool movesAll)
{
    btVector3 origin = plane.above.soft != nullptr   ? plane.above.soft->positions[plane.above.vertices[0]]
                       : plane.below.soft != nullptr ? plane.below.soft->positions[plane.below.vertices[0]]
                                                     : plane.above.rigid->start.getOrigin();
    const btScalar missing =
        plane.gap - LowestOf(plane.above, plane.normal, origin) - LowestOf(plane.below, -plane.normal, origin);
    // Most planes hold in most sweeps.
    if (missing <= 0)
        return false;
    Corners above(plane.above, plane.normal, origin, movesAll), below(plane.below, -plane.normal, origin, movesAll);
    if (!above.moves && !below.moves)
        return false;
    btScalar share = FindShare(above, below, missing);
    btScalar floorAbove = above.lowest + share * missing, floorBelow = below.lowest + (1 - share) * missing;
    // Many planes push a guided body out of nodes that stay, each for itself: friction of all would hold it fast.
    btVector3 friction = movesAll ? FindFriction(plane, above, floorAbove, below, floorBelow) : btVector3(0, 0, 0);
    if (!friction.isZero() && (above.IsGuided() || below.IsGuided()))
    {
        if (!above.TakeFriction(friction) || !below.TakeFriction(-friction))
        {
            friction.setZero();
            above.TakeFriction(friction);
        }
        share = FindShare(above, below, missing);
        floorAbove = above.lowest + share * missing;
        floorBelow = below.lowest + (1 - share) * missing;
    }
    above.Raise(floorAbove, friction);
    below.Raise(floorBelow, -friction);
    return true;
}

btScalar ThicknessOf(const qcPlaneSide& side)
{
    return side.soft != nullptr ? side.soft->thickness / 2 : side.mesh->shape->getMargin();
}

/// One side is that of a soft body.
btScalar FrictionOf(const qcPlaneSide& a, const qcPlaneSide& b)
{
    if (a.soft == nullptr)
        return FrictionOf(b, a);
    return b.soft != nullptr ? (a.soft->Friction() + b.soft->Friction()) / 2 : a.soft->FrictionOn(*b.rigid->object);
}

/// The corners of both triangles.
struct TouchingPair
{
    qcPlaneSide sides[2];
    Corners above, below;

    TouchingPair(qcSoftBodyScene& scene, const qcUnprovenPair& unproven)
        : sides{SideOf(scene, unproven.pair.bodyA, unproven.pair.triangleA),
                SideOf(scene, unproven.pair.bodyB, unproven.pair.triangleB)},
          above(sides[0], unproven.normal, btVector3(0, 0, 0)), below(sides[1], -unproven.normal, btVector3(0, 0, 0))
    {
    }

    /// True if the direction separates the triangles at the start, up to rounding.
    bool SeparatesAtStart(const btVector3& direction) const
    {
        btScalar lowest = BT_LARGE_FLOAT, highest = -BT_LARGE_FLOAT, size = 0;
        for (int i = 0; i < sides[0].count; i++)
            lowest = std::min(lowest, direction.dot(above.corner[i].start));
        for (int i = 0; i < sides[1].count; i++)
        {
            highest = std::max(highest, direction.dot(below.corner[i].start));
            size = std::max(size, btFabs(direction.dot(below.corner[i].start)));
        }
        return lowest - highest >= -8 * SIMD_EPSILON * size;
    }

    /// The direction that separates the triangles best at the start: a face normal, or normal to two edges.
    btVector3 FindDirection() const
    {
        btVector3 edges[2][3], axes[17], best(0, 1, 0);
        for (int c = 0; c < 3; c++)
        {
            edges[0][c] = StartOf(0, c + 1) - StartOf(0, c);
            edges[1][c] = StartOf(1, c + 1) - StartOf(1, c);
        }
        int count = 0;
        for (int side = 0; side < 2; side++)
        {
            btVector3 normal = axes[count++] = edges[side][0].cross(edges[side][1]);
            for (int c = 0; c < 3; c++)
                axes[count++] = normal.cross(edges[side][c]);
        }
        for (int i = 0; i < 9; i++)
            axes[count++] = edges[0][i / 3].cross(edges[1][i % 3]);
        btScalar widest = -BT_LARGE_FLOAT;
        for (int i = 0; i < 2 * count; i++)
        {
            btScalar length = axes[i / 2].length();
            if (length <= 0)
                continue;
            btVector3 axis = axes[i / 2] * ((i & 1 ? 1 : -1) / length);
            btScalar gap = BT_LARGE_FLOAT;
            for (int k = 0; k < 9; k++)
                gap = std::min(gap, axis.dot(StartOf(0, k / 3) - StartOf(1, k % 3)));
            if (gap <= widest)
                continue;
            widest = gap;
            best = axis;
        }
        return best;
    }

    btVector3 StartOf(int side, int c) const
    {
        return (side == 0 ? above : below).corner[c % 3 < sides[side].count ? c % 3 : 0].start;
    }

    /// The relation at present; `normal`: from the closest point of B to that of A, if they are disjoint.
    qcRelation FindEnd(btVector3* normal) const
    {
        double a[9], b[9];
        for (int i = 0; i < 9; i++)
        {
            a[i] = double(above.corner[std::min(i / 3, sides[0].count - 1)].end[i % 3]);
            b[i] = double(below.corner[std::min(i / 3, sides[1].count - 1)].end[i % 3]);
        }
        qcProximity proximity;
        qcTrianglesWithin(a, b, double(BT_LARGE_FLOAT), &proximity);
        *normal = qcVectorOf(proximity.normal);
        return proximity.distance > 0 ? qc_relationDisjoint : qcRelateTriangles(a, b);
    }
};
} // namespace

qcUnprovenPair qcMakeUnproven(qcSoftBodyScene& scene, const qcPair& pair, const qcProximity& start)
{
    qcUnprovenPair unproven = {pair, qcVectorOf(start.normal), btScalar(start.distance)};
    if (pair.relation == qc_relationPenetrating || start.distance <= 0)
        return unproven;
    double size = 0;
    for (int axis = 0; axis < 3; axis++)
        size = std::max(size, std::fabs(start.pointA[axis]));
    if (start.distance > s_minDistance * (1 + size))
        return unproven;
    unproven.normal = TouchingPair(scene, unproven).FindDirection();
    unproven.distance = 0;
    return unproven;
}

qcTouchingMotion qcClassifyTouching(qcSoftBodyScene& scene, const qcUnprovenPair& unproven, bool isInZone)
{
    TouchingPair pair(scene, unproven);
    if (!pair.SeparatesAtStart(unproven.normal))
        return qcTouchingMotion::Entangled;
    if (pair.above.lowest + pair.below.lowest > 0)
        return qcTouchingMotion::Proven;
    // Triangles that touch along edges have more than one direction of least penetration: that of the end may separate
    // them at the start, too.
    btVector3 normal;
    qcRelation end = pair.FindEnd(&normal);
    bool isProven =
        isInZone ? end != qc_relationPenetrating : end == qc_relationDisjoint && pair.SeparatesAtStart(normal);
    return isProven ? qcTouchingMotion::Proven : qcTouchingMotion::Unproven;
}

void qcSeparatingPlanes::Clear()
{
    m_planes.clear();
    m_pairs.clear();
}

void qcSeparatingPlanes::Add(qcSoftBodyScene& scene, const qcUnprovenPair& unproven, btScalar widening)
{
    const qcPair& pair = unproven.pair;
    if (!m_pairs.insert({pair.bodyA, pair.triangleA, pair.bodyB, pair.triangleB}).second)
        return;
    qcSeparatingPlane plane;
    plane.above = SideOf(scene, pair.bodyA, pair.triangleA);
    plane.below = SideOf(scene, pair.bodyB, pair.triangleB);
    plane.normal = unproven.normal;
    // Contacts restore the thickness; a plane only restores a gap, no larger than that of the start.
    btScalar thickness = ThicknessOf(plane.above) + ThicknessOf(plane.below);
    plane.gap = unproven.distance > 0 ? std::min(unproven.distance + widening * thickness, thickness / 4)
                                      : (s_touchingGap + widening) * thickness;
    plane.friction = FrictionOf(plane.above, plane.below);
    m_planes.push_back(plane);
}

bool qcSeparatingPlanes::HasGuided() const
{
    auto isGuided = [](const qcPlaneSide& side) { return side.rigid != nullptr && side.rigid->isGuided; };
    return std::any_of(m_planes.begin(), m_planes.end(),
                       [&isGuided](const qcSeparatingPlane& plane)
                       { return isGuided(plane.above) || isGuided(plane.below); });
}

void qcSeparatingPlanes::Solve(int sweeps, bool movesAll)
{
    bool moved = true;
    for (int i = 0; i < sweeps && moved; i++)
    {
        moved = false;
        for (const qcSeparatingPlane& plane : m_planes)
            moved = SolvePlane(plane, movesAll) || moved;
    }
}
