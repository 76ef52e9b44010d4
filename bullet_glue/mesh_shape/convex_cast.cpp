// Convex casts through a mesh: triangles in the order of a lower bound of their time of impact, from separating axes.
// Ericson: Real-Time Collision Detection, 2005, section 5.5.
#include "mesh_shape/convex_cast.h"

#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>

#include <cstring>
#include <typeinfo>

namespace
{
/// Bullet's conservative advancement ends within a millimetre; the rest is for the error of its distances.
constexpr btScalar s_tolerance = btScalar(2e-3);
constexpr btScalar s_never = 2; ///< a fraction behind the end of the way

/// A convex shape on its way, in the mesh's frame.
class MovingShape
{
  public:
    explicit MovingShape(const btTriangleConvexcastCallback& cast)
        : m_shape(*cast.m_convexShape), m_from(cast.m_triangleToWorld.invXform(cast.m_convexShapeFrom.getOrigin())),
          m_way(cast.m_triangleToWorld.invXform(cast.m_convexShapeTo.getOrigin()) - m_from),
          m_toShape(cast.m_convexShapeFrom.getBasis().transposeTimes(cast.m_triangleToWorld.getBasis())),
          m_turns(!(cast.m_convexShapeFrom.getBasis() == cast.m_convexShapeTo.getBasis())),
          m_radius(m_shape.getAngularMotionDisc())
    {
        btScalar scale = m_from.length() + m_way.length() + m_radius;
        m_reach = cast.m_triangleCollisionMargin + s_tolerance + btMax(btScalar(0), -cast.m_allowedPenetration) +
                  16 * std::numeric_limits<btScalar>::epsilon() * scale;
    }

    qcTriangleTree::Sweep GetSweep() const
    {
        qcTriangleTree::Sweep sweep = {m_from, m_from + m_way, btVector3(0, 0, 0), btVector3(0, 0, 0)};
        for (int axis = 0; axis < 3; axis++)
        {
            btVector3 direction(0, 0, 0);
            direction[axis] = 1;
            sweep.upper[axis] = Extent(direction) + m_reach;
            sweep.lower[axis] = -Extent(-direction) - m_reach;
        }
        return sweep;
    }

    /// A fraction of the way before which the triangle is not hit.
    btScalar Bound(const btVector3& a, const btVector3& b, const btVector3& c) const
    {
        btScalar bound = 0;
        btVector3 normal = (b - a).cross(c - a), aside = (a + b + c) / 3 - m_from;
        if (normal.dot(aside) < 0)
            normal = -normal;
        btScalar square = normal.length2();
        if (HasRoot(square))
            bound = BoundAlong(normal / btSqrt(square), a, b, c);
        // From the line of the way to the triangle.
        square = m_way.length2();
        if (bound < s_never && HasRoot(square))
            aside -= m_way * (aside.dot(m_way) / square);
        square = aside.length2();
        if (bound < s_never && HasRoot(square))
            bound = btMax(bound, BoundAlong(aside / btSqrt(square), a, b, c));
        return bound;
    }

  private:
    /// True if a vector with this square of its length can be scaled to a length of 1 with all digits.
    static bool HasRoot(btScalar square)
    {
        constexpr btScalar lowest = std::numeric_limits<btScalar>::min() * btScalar(1e8);
        constexpr btScalar highest = std::numeric_limits<btScalar>::max() * btScalar(1e-8);
        return square > lowest && square < highest;
    }

    /// How far the shape reaches from its origin in a direction of length 1, at any time.
    btScalar Extent(const btVector3& direction) const
    {
        if (m_turns)
            return m_radius;
        btVector3 inShape = m_toShape * direction;
        return inShape.dot(m_shape.localGetSupportingVertex(inShape));
    }

    /// The bound from one axis, of length 1, which points from the shape to the triangle.
    btScalar BoundAlong(const btVector3& axis, const btVector3& a, const btVector3& b, const btVector3& c) const
    {
        btScalar nearest = btMin(btMin(axis.dot(a - m_from), axis.dot(b - m_from)), axis.dot(c - m_from));
        btScalar gap = nearest - m_reach;
        // Most triangles near the way are far along it; the support point is what costs.
        if (gap <= 0)
            return 0;
        gap -= Extent(axis);
        btScalar approach = axis.dot(m_way);
        return gap <= 0 ? btScalar(0) : approach <= gap ? s_never : gap / approach;
    }

    const btConvexShape& m_shape;
    const btVector3 m_from, m_way;
    const btMatrix3x3 m_toShape;
    const bool m_turns;
    const btScalar m_radius;
    btScalar m_reach; ///< of the triangles: margin and tolerance
};

/// Casts by Bullet's algorithm, and shortens the cast by hits that the callback's result names as its closest.
class ShortenedCast : public btTriangleConvexcastCallback
{
  public:
    explicit ShortenedCast(btTriangleConvexcastCallback* cast) : btTriangleConvexcastCallback(*cast), m_cast(cast)
    {
    }

    btScalar reportHit(const btVector3& normal, const btVector3& point, btScalar fraction, int part,
                       int triangle) override
    {
        btScalar result = m_cast->reportHit(normal, point, fraction, part, triangle);
        if (result == fraction && fraction > 0)
            m_hitFraction = m_startHit ? btScalar(0) : fraction;
        // A callback may return 0 whatever it is given: a later hit shows if this one does.
        m_startHit = m_startHit || (result == 0 && fraction == 0);
        return result;
    }

  private:
    btTriangleConvexcastCallback* m_cast;
    bool m_startHit = false; ///< a result of 0 for a hit at the start of the way
};

/// True for the callback of btCollisionWorld::objectQuerySingleInternal. It has no name outside of that function, and
/// its processTriangle is its base's.
bool IsWorlds(const btTriangleConvexcastCallback& cast)
{
    return std::strstr(typeid(cast).name(), "objectQuerySingleInternal") != nullptr;
}
} // namespace

void qcCastThroughMesh(const qcTriangleTree& tree, const btVector3* points, const uint32_t* indices,
                       btTriangleConvexcastCallback* cast)
{
    const MovingShape shape(*cast);
    ShortenedCast shortened(cast);
    btTriangleConvexcastCallback* receiver = IsWorlds(*cast) ? &shortened : cast;
    auto bound = [&](uint32_t triangle)
    {
        const uint32_t* index = &indices[3 * size_t(triangle)];
        return shape.Bound(points[index[0]], points[index[1]], points[index[2]]);
    };
    auto visit = [&](uint32_t triangle)
    {
        const uint32_t* index = &indices[3 * size_t(triangle)];
        btVector3 corners[3] = {points[index[0]], points[index[1]], points[index[2]]};
        receiver->processTriangle(corners, 0, int(triangle));
    };
    tree.VisitInOrder(shape.GetSweep(), receiver->m_hitFraction, bound, visit);
}
