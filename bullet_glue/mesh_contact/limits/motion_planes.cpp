// Separating planes between triangles of two meshes that are not proven apart over a step.
#include "mesh_contact/limits/motion_planes.h"

#include "common/rigid_displacement.h"

#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

#include <algorithm>

namespace
{
// Relative gap that certificates of motion need.
constexpr btScalar s_certifiable = btScalar(1e-13);
// A body on a floor gives way to a push by at least this part of its motion along the floor, or not at all.
constexpr btScalar s_minAlongFloor = btScalar(0.5);
// Relative rounding of a stored corner: of the transform's rotation, the product and the sum.
constexpr btScalar s_rounding = 16 * SIMD_EPSILON;

/// The corner that is furthest against the direction.
struct Extreme
{
    btScalar height = BT_LARGE_FLOAT; ///< along the direction
    btVector3 arm{0, 0, 0};           ///< from the object's centre

    Extreme(const qcMotionPlaneSide& side, const btVector3& direction)
    {
        if (side.isWhole)
        {
            const qcPlacedSupport hull{side.swept->hull, side.swept->end};
            btVector3 point = hull.VertexAt(hull.mesh->Vertices().FindMax(hull.ToLocal(-direction)));
            height = direction.dot(point);
            arm = point - side.swept->end.getOrigin();
            return;
        }
        for (const btVector3& local : side.corners)
        {
            btVector3 point = side.swept->end * local;
            btScalar level = direction.dot(point);
            if (level < height)
            {
                height = level;
                arm = point - side.swept->end.getOrigin();
            }
        }
    }
};

/// How an object gives way to a push.
struct Yield
{
    btVector3 linear, angular; ///< displacement and rotation by a unit impulse, times the time step
    btScalar along;            ///< displacement of the point along the impulse

    /// By an impulse on `swept` at `arm`, from the other object.
    Yield(const qcSweptObject& swept, const qcSweptObject& other, const btVector3& arm, const btVector3& direction)
        : linear(0, 0, 0), angular(0, 0, 0), along(0)
    {
        if (!swept.CanBePushedBy(other))
            return;
        const bool isGuided = swept.body == nullptr || !qcIsFree(*swept.body);
        const qcRigidDisplacement by = swept.body != nullptr ? qcDisplacementBy(*swept.body, arm, direction)
                                                             : swept.multibody->DisplacementBy(swept, arm, direction);
        if (isGuided && qcIsLedElsewhere(by.At(arm), direction))
            return;
        linear = by.linear;
        angular = by.angular;
        along = direction.dot(linear) + direction.dot(angular.cross(arm));
        // A body that lies on a floor and is pushed into it: the floor does not give way, the body neither sinks nor
        // tilts.
        for (const qcSweptFloor& floor : swept.floors)
            if (direction.dot(floor.normal) < 0 && floor.HeightOf(*swept.hull, swept.end) <= 0)
            {
                angular.setZero();
                linear -= floor.normal * std::min(linear.dot(floor.normal), btScalar(0));
                // Pushed nearly straight into the floor it would slide away by metres.
                if (qcIsLedElsewhere(linear, direction, s_minAlongFloor))
                    linear.setZero();
                along = direction.dot(linear);
            }
    }
};

/// True if a vertex is below a floor.
bool IsInFloor(const qcSweptObject& swept)
{
    return std::any_of(swept.floors.begin(), swept.floors.end(),
                       [&swept](const qcSweptFloor& floor) { return floor.HeightOf(*swept.hull, swept.end) < 0; });
}

/// An impulse along `direction` at `arm`, times the time step: moves the end of the object by its yield times as much.
void Push(qcSweptObject* swept, const Yield& yield, btScalar impulse, const btVector3& arm, const btVector3& direction)
{
    if (yield.along == 0)
        return;
    if (swept->multibody != nullptr)
    {
        swept->multibody->Push(*swept, arm, direction * impulse);
        return;
    }
    const btTransform before = swept->end;
    swept->end = qcDisplaced(before, {yield.angular * impulse, yield.linear * impulse});
    swept->pushes++;
    if (!IsInFloor(*swept))
        return;
    // It comes to lie on the floor: turned about that, it would be lifted.
    swept->end.setBasis(before.getBasis());
    for (const qcSweptFloor& floor : swept->floors)
        swept->end.setOrigin(swept->end.getOrigin() -
                             floor.normal * std::min(floor.HeightOf(*swept->hull, swept->end), btScalar(0)));
}

void SolvePlane(qcMotionPlane* plane)
{
    const uint32_t pushes[2] = {plane->above.swept->pushes, plane->below.swept->pushes};
    if (pushes[0] == plane->held[0] && pushes[1] == plane->held[1])
        return;
    Extreme lowest(plane->above, plane->normal), highest(plane->below, -plane->normal);
    btScalar lack = plane->gap - lowest.height - highest.height;
    if (!(lack > 0))
    {
        std::copy(pushes, pushes + 2, plane->held);
        return;
    }
    const qcSweptObject &objectAbove = *plane->above.swept, &objectBelow = *plane->below.swept;
    const Yield above(objectAbove, objectBelow, lowest.arm, plane->normal);
    const Yield below(objectBelow, objectAbove, highest.arm, -plane->normal);
    const btScalar inverseMass = above.along + below.along;
    if (!(inverseMass > 0))
        return;
    Push(plane->above.swept, above, lack / inverseMass, lowest.arm, plane->normal);
    Push(plane->below.swept, below, lack / inverseMass, highest.arm, -plane->normal);
    plane->pushed += lack / inverseMass;
}

/// Upper bound of the coordinates of two objects at their ends.
btScalar LargestCoordinate(const qcSweptObject& a, const qcSweptObject& b)
{
    return std::max(a.end.getOrigin().length(), b.end.getOrigin().length()) + a.radius + b.radius;
}

btVector3 VelocityAt(const qcSweptObject& swept, const btVector3& arm)
{
    if (swept.multibody != nullptr)
        return swept.multibody->VelocityAt(swept, arm);
    const btRigidBody* body = btRigidBody::upcast(swept.object);
    return body != nullptr ? body->getVelocityInLocalPoint(arm) : btVector3(0, 0, 0);
}

/// An impulse of the other object on `swept`.
void ApplyImpulse(const qcSweptObject& swept, const qcSweptObject& other, const btVector3& arm,
                  const btVector3& impulse)
{
    if (swept.body != nullptr)
        swept.body->applyImpulse(impulse, arm);
    else if (swept.multibody != nullptr)
        swept.multibody->ApplyImpulse(swept, arm, impulse, other.IsSwept());
}

/// The points of both sides that are nearest to each other at the ends, or the corners of whole hulls that are furthest
/// against the plane: where the sides meet is between them.
btVector3 MeetingPointOf(const qcMotionPlane& plane)
{
    const qcMotionPlaneSide &above = plane.above, &below = plane.below;
    const Extreme lowest(above, plane.normal), highest(below, -plane.normal);
    btVector3 points[2] = {above.swept->end.getOrigin() + lowest.arm, below.swept->end.getOrigin() + highest.arm};
    if (!above.isWhole && !below.isWhole)
    {
        double corners[2][9];
        for (int i = 0; i < 9; i++)
        {
            corners[0][i] = double((above.swept->end * above.corners[i / 3])[i % 3]);
            corners[1][i] = double((below.swept->end * below.corners[i / 3])[i % 3]);
        }
        qcProximity nearest;
        if (qcTrianglesWithin(corners[0], corners[1], double(BT_LARGE_FLOAT), &nearest))
        {
            points[0] = qcVectorOf(nearest.pointA);
            points[1] = qcVectorOf(nearest.pointB);
        }
    }
    return (points[0] + points[1]) / 2;
}

/// The velocity of below against above where they meet.
btVector3 RelativeVelocityOf(const qcMotionPlane& plane)
{
    return VelocityAt(*plane.below.swept, plane.arms[1]) - VelocityAt(*plane.above.swept, plane.arms[0]);
}

btScalar FrictionOf(const qcMotionPlane& plane)
{
    return std::max(gCalculateCombinedFrictionCallback(plane.above.swept->object, plane.below.swept->object),
                    btScalar(0));
}

/// 0 for links: see qcBounces.
btScalar RestitutionOf(const qcMotionPlane& plane)
{
    const qcSweptObject &above = *plane.above.swept, &below = *plane.below.swept;
    return above.owner != nullptr || below.owner != nullptr
               ? btScalar(0)
               : btClamped(gCalculateCombinedRestitutionCallback(above.object, below.object), btScalar(0), btScalar(1));
}

/// The speed of a point along a direction by a unit impulse on it.
btScalar InverseMassOf(const qcSweptObject& swept, const btVector3& arm, const btVector3& direction)
{
    if (swept.multibody != nullptr)
        return swept.multibody->DisplacementBy(swept, arm, direction).At(arm).dot(direction);
    return swept.body == nullptr
               ? btScalar(0)
               : swept.body->computeImpulseDenominator(swept.body->getCenterOfMassPosition() + arm, direction);
}

/// Changes an impulse along a direction, between 0 and a limit, so that above is faster than below by this speed: it
/// becomes less where other planes have done a part.
void SolveImpulse(const qcMotionPlane& plane, const btVector3& direction, btScalar speed, btScalar limit,
                  btScalar* impulse)
{
    const qcSweptObject &above = *plane.above.swept, &below = *plane.below.swept;
    const btScalar inverseMass =
        InverseMassOf(above, plane.arms[0], direction) + InverseMassOf(below, plane.arms[1], direction);
    if (!(inverseMass > 0))
        return;
    const btScalar lacking = direction.dot(RelativeVelocityOf(plane)) + speed;
    const btScalar sum = btClamped(*impulse + lacking / inverseMass, btScalar(0), limit);
    const btVector3 change = direction * (sum - *impulse);
    ApplyImpulse(above, below, plane.arms[0], change);
    ApplyImpulse(below, above, plane.arms[1], -change);
    *impulse = sum;
}
} // namespace

btScalar qcCornerRounding(const qcSweptObject& a, const qcSweptObject& b)
{
    return s_rounding * LargestCoordinate(a, b);
}

btScalar qcTouchingDepth(const qcSweptObject& a, const qcSweptObject& b)
{
    return std::max(s_rounding, s_certifiable) * LargestCoordinate(a, b) / 2;
}

btScalar qcCertifiableGap(const qcSweptObject& a, const qcSweptObject& b)
{
    return s_certifiable * LargestCoordinate(a, b);
}

void qcMotionPlanes::Clear()
{
    m_planes.clear();
    m_pairs.clear();
}

void qcMotionPlanes::Add(const qcPair& pair, const qcMotionPlaneSide& a, const qcMotionPlaneSide& b,
                         const qcProximity& nearest)
{
    if (!m_pairs.insert({pair.bodyA, pair.triangleA, pair.bodyB, pair.triangleB}).second)
        return;
    btScalar floor = qcMotionFloor * (a.swept->Margin() + b.swept->Margin());
    qcMotionPlane plane;
    plane.above = a;
    plane.below = b;
    plane.normal = qcVectorOf(nearest.normal);
    plane.gap = std::max(std::min(btScalar(nearest.distance), floor), qcCornerRounding(*a.swept, *b.swept));
    plane.pushed = 0;
    plane.arms[0] = plane.arms[1] = btVector3(0, 0, 0);
    m_planes.push_back(plane);
}

void qcMotionPlanes::AddHulls(qcSweptObject* below, qcSweptObject* above, const btVector3& normal, btScalar gap)
{
    if (!m_pairs.insert({below->number, UINT32_MAX, above->number, UINT32_MAX}).second)
        return;
    const btVector3 zero(0, 0, 0);
    m_planes.push_back({{above, {}, true}, {below, {}, true}, normal, gap, 0, {zero, zero}});
}

void qcMotionPlanes::SolveOnce()
{
    for (qcMotionPlane& plane : m_planes)
        SolvePlane(&plane);
}

void qcMotionPlanes::StopAll(int sweeps, btScalar slowest)
{
    for (qcMotionPlane* plane : m_stopped)
    {
        // One point for both: impulses on two points that are apart would change the angular momentum.
        const btVector3 point = MeetingPointOf(*plane);
        plane->arms[0] = point - plane->above.swept->end.getOrigin();
        plane->arms[1] = point - plane->below.swept->end.getOrigin();
        plane->approach = plane->normal.dot(RelativeVelocityOf(*plane));
        plane->restitution = plane->approach >= slowest ? RestitutionOf(*plane) : btScalar(0);
    }
    for (int sweep = 0; sweep < sweeps; sweep++)
        for (qcMotionPlane* plane : m_stopped)
            SolveImpulse(*plane, plane->normal, 0, BT_LARGE_FLOAT, &plane->stopping);
}

void qcMotionPlanes::RubAll(int sweeps)
{
    for (qcMotionPlane* plane : m_stopped)
    {
        const btVector3 relative = RelativeVelocityOf(*plane);
        const btVector3 sliding = relative - plane->normal * plane->normal.dot(relative);
        const btScalar speed = sliding.length();
        plane->along = speed > SIMD_EPSILON ? sliding / speed : btVector3(0, 0, 0);
        // Fixed: bounds that follow the impulses could raise the kinetic energy.
        plane->mostRubbing = FrictionOf(*plane) * plane->stopping;
    }
    for (int sweep = 0; sweep < sweeps; sweep++)
        for (qcMotionPlane* plane : m_stopped)
        {
            SolveImpulse(*plane, plane->along, 0, plane->mostRubbing, &plane->rubbing);
            SolveImpulse(*plane, plane->normal, 0, BT_LARGE_FLOAT, &plane->stopping);
        }
}

void qcMotionPlanes::BounceAll(int sweeps)
{
    for (int sweep = 0; sweep < sweeps; sweep++)
        for (qcMotionPlane* plane : m_stopped)
            if (plane->restitution > 0)
                SolveImpulse(*plane, plane->normal, plane->restitution * plane->approach,
                             plane->restitution * plane->stopping, &plane->parting);
}
