// Pairs of triangles that the detection of a step has not proven apart.
#include "mesh_contact/limits/swept_triangles.h"

#include <algorithm>

namespace
{
/// Corners of two triangles.
struct Corners
{
    double a[9], b[9];

    Corners(const qcSweptTriangles& triangles, const btTransform& atA, const btTransform& atB, bool atStart)
    {
        triangles.a.CornersAt(atA, atStart, a);
        triangles.b.CornersAt(atB, atStart, b);
    }

    /// The smallest translation that separates them; a depth of 0 if they are apart.
    qcProximity Penetration() const
    {
        qcProximity proximity = {};
        qcTrianglesWithin(a, b, 0, &proximity);
        return proximity;
    }

    /// The smallest product of A's corners with a direction, minus the largest of B's.
    btScalar GapAlong(const btVector3& direction) const
    {
        return btScalar(ProductsWith(a, direction).first - ProductsWith(b, direction).second);
    }

    /// The extent of both along a direction.
    btScalar ExtentAlong(const btVector3& direction) const
    {
        auto [lowA, highA] = ProductsWith(a, direction);
        auto [lowB, highB] = ProductsWith(b, direction);
        return btScalar(std::max(highA, highB) - std::min(lowA, lowB));
    }

  private:
    /// The smallest and the largest product of a triangle's corners with a direction.
    static std::pair<double, double> ProductsWith(const double corners[9], const btVector3& direction)
    {
        auto product = [&](const double* corner) {
            return corner[0] * double(direction[0]) + corner[1] * double(direction[1]) +
                   corner[2] * double(direction[2]);
        };
        return std::minmax({product(corners), product(corners + 3), product(corners + 6)});
    }
};

/// The vector between two corners.
btVector3 Between(const double* from, const double* to)
{
    return btVector3(btScalar(to[0] - from[0]), btScalar(to[1] - from[1]), btScalar(to[2] - from[2]));
}

/// Two triangles that may lie in one plane.
struct Facing
{
    btScalar cosine;  ///< its sign is that of the cosine between their normals
    btVector3 across; ///< along the normal of the larger one, which is more exact; from B to A if they face each other

    explicit Facing(const Corners& corners)
    {
        const btVector3 areaA = AreaOf(corners.a), areaB = AreaOf(corners.b);
        cosine = areaA.dot(areaB);
        across = areaA.length2() > areaB.length2() ? -areaA : areaB;
    }

  private:
    /// Twice the area of a triangle, along its normal.
    static btVector3 AreaOf(const double corners[9])
    {
        return Between(corners, corners + 3).cross(Between(corners, corners + 6));
    }
};

/// The largest gap of two triangles in one plane, along the normals of their edges; below 0: they overlap.
btScalar GapInPlane(const Corners& corners, const btVector3& normal)
{
    btScalar gap = -BT_LARGE_FLOAT;
    for (const double* triangle : {corners.a, corners.b})
        for (int c = 0; c < 3; c++)
        {
            btVector3 along = Between(triangle + 3 * c, triangle + 3 * ((c + 1) % 3));
            btVector3 across = along.cross(normal).normalized();
            gap = std::max({gap, corners.GapAlong(across), corners.GapAlong(-across)});
        }
    return gap;
}

/// True if triangles that meet at the start are too deep in each other.
bool AreTooDeep(const qcSweptTriangles& triangles, const Corners& corners)
{
    // Nearly all that touch are still apart along the direction of the start.
    return corners.GapAlong(qcVectorOf(triangles.atStart->normal)) < -triangles.maxDepth &&
           btScalar(corners.Penetration().depth) > triangles.maxDepth;
}

Corners AtStart(const qcSweptTriangles& triangles)
{
    return Corners(triangles, triangles.a.swept->start, triangles.b.swept->start, true);
}

Corners AtEnd(const qcSweptTriangles& triangles)
{
    return Corners(triangles, triangles.a.swept->end, triangles.b.swept->end, false);
}
} // namespace

void qcSweptTriangle::CornersAt(const btTransform& transform, bool atStart, double corners[9]) const
{
    const btTransform place = transform * mesh->local;
    for (size_t c = 0; c < 3; c++)
    {
        btVector3 p = place * mesh->PointOf(number, c, atStart);
        for (int axis = 0; axis < 3; axis++)
            corners[3 * c + size_t(axis)] = double(p[axis]);
    }
}

qcMotionPlaneSide qcSweptTriangle::PlaneSide() const
{
    qcMotionPlaneSide side{swept, {}};
    for (size_t c = 0; c < 3; c++)
        side.corners[c] = mesh->local * mesh->PointOf(number, c, false);
    return side;
}

bool qcSweptTriangles::ArePenetrating(btScalar touchingDepth) const
{
    if (btScalar(atStart->depth) > touchingDepth)
        return true;
    const Corners start = AtStart(*this);
    const Facing sides(start);
    return sides.cosine > 0 && start.ExtentAlong(sides.across.normalized()) <= 4 * touchingDepth &&
           GapInPlane(start, sides.across.normalized()) < -touchingDepth;
}

void qcSweptTriangles::MeetWithin(btScalar touchingDepth)
{
    if (btScalar(atStart->distance) > touchingDepth)
        return;
    meet = true;
    const Corners start = AtStart(*this);
    // The scene's corners are rounded otherwise.
    maxDepth = touchingDepth;
    if (btScalar(atStart->depth) > touchingDepth / 2)
        maxDepth = std::max(maxDepth, btScalar(start.Penetration().depth));
    const Facing sides(start);
    if (sides.cosine < 0 && start.ExtentAlong(sides.across.normalized()) <= 2 * touchingDepth)
        facing = sides.across.normalized();
}

bool qcSweptTriangles::IsUnproven(bool pushes) const
{
    if (!meet)
        return true;
    Corners end = AtEnd(*this);
    if (pushes && FaceEachOther() && end.GapAlong(facing) < maxDepth)
        return true;
    return AreTooDeep(*this, end);
}

btScalar qcSweptTriangles::FindPart(btScalar limit) const
{
    Corners start = AtStart(*this);
    auto holds = [&](btScalar part)
    {
        Corners end(*this, a.swept->EndAt(part), b.swept->EndAt(part), false);
        return meet ? !AreTooDeep(*this, end) : qcTrianglesStayApart(start.a, end.a, start.b, end.b, nullptr);
    };
    return qcFindLargestPart(limit, holds);
}

void qcSweptTriangles::AddPlane(qcMotionPlanes* planes) const
{
    qcProximity nearest = *atStart;
    if (FaceEachOther())
        for (int axis = 0; axis < 3; axis++)
            nearest.normal[axis] = double(facing[axis]);
    else if (meet)
    {
        // Triangles that touch are separated along many directions: the one with the smallest push is taken.
        const qcProximity atEnd = AtEnd(*this).Penetration();
        if (atEnd.depth > 0 && AtStart(*this).GapAlong(qcVectorOf(atEnd.normal)) >= -2 * maxDepth)
            nearest = atEnd;
    }
    if (meet)
        nearest.distance = 2 * double(maxDepth);
    planes->Add(*pair, a.PlaneSide(), b.PlaneSide(), nearest);
}
