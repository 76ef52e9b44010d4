// How far two boxes in general position are apart, at least.
#include "mesh_contact/box_gap.h"

#include <algorithm>
#include <limits>

namespace
{
// Cross products of nearly parallel edges have no direction, and none is needed: the faces' normals do.
constexpr btScalar s_minSine2 = btScalar(1e-4);

/// Half the extent of a box along a direction.
btScalar ExtentAlong(const btVector3& half, const btMatrix3x3& basis, const btVector3& direction)
{
    return half.dot((direction * basis).absolute());
}
} // namespace

btScalar qcBoxGap(const qcPlacedBox& a, const qcPlacedBox& b)
{
    btVector3 halfA = (a.upper - a.lower) / 2, halfB = (b.upper - b.lower) / 2;
    btVector3 centreA = a.transform * ((a.lower + a.upper) / 2), centreB = b.transform * ((b.lower + b.upper) / 2);
    const btMatrix3x3 &basisA = a.transform.getBasis(), &basisB = b.transform.getBasis();
    btVector3 between = centreB - centreA;
    btScalar gap = -BT_LARGE_FLOAT;
    auto take = [&](const btVector3& unit)
    {
        gap = std::max(gap,
                       btFabs(unit.dot(between)) - ExtentAlong(halfA, basisA, unit) - ExtentAlong(halfB, basisB, unit));
    };
    for (int i = 0; i < 3; i++)
    {
        take(basisA.getColumn(i));
        take(basisB.getColumn(i));
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
        {
            btVector3 cross = basisA.getColumn(i).cross(basisB.getColumn(j));
            if (cross.length2() > s_minSine2)
                take(cross.normalized());
        }
    btScalar size = centreA.length() + centreB.length() + halfA.length() + halfB.length();
    return gap - 32 * std::numeric_limits<btScalar>::epsilon() * size;
}
