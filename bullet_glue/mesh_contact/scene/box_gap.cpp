// Lower bound of the distance of two boxes in general position.
#include "mesh_contact/scene/box_gap.h"

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
    auto gapAlong = [&](const btVector3& unit)
    { return btFabs(unit.dot(between)) - ExtentAlong(halfA, basisA, unit) - ExtentAlong(halfB, basisB, unit); };
    btVector3 inA = between * basisA, inB = between * basisB;
    // B's axes in A's frame.
    btMatrix3x3 turn = basisA.transposeTimes(basisB), part = turn.absolute();
    btVector3 gapsA = inA.absolute() - halfA - part * halfB, gapsB = inB.absolute() - halfB - halfA * part;
    btScalar gap = std::max(gapsA[gapsA.maxAxis()], gapsB[gapsB.maxAxis()]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
        {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            btScalar extents =
                halfA[i1] * part[i2][j] + halfA[i2] * part[i1][j] + halfB[j1] * part[i][j2] + halfB[j2] * part[i][j1];
            btScalar apart = btFabs(inA[i2] * turn[i1][j] - inA[i1] * turn[i2][j]) - extents;
            btScalar length2 = turn[i1][j] * turn[i1][j] + turn[i2][j] * turn[i2][j];
            if (!(apart > 0) || (gap > 0 && apart * apart <= gap * gap * length2))
                continue;
            // Again along a unit vector: the error of `apart` grows with its inverse length.
            btVector3 cross = basisA.getColumn(i).cross(basisB.getColumn(j));
            if (cross.length2() > s_minSine2)
                gap = std::max(gap, gapAlong(cross.normalized()));
        }
    btScalar size = centreA.length() + centreB.length() + halfA.length() + halfB.length();
    return gap - 32 * std::numeric_limits<btScalar>::epsilon() * size;
}
