// Shapes in place of the dragon and the bunny, where their files can't be had.
#ifndef QC_DEMOS_BREAKING_STAND_IN_H
#define QC_DEMOS_BREAKING_STAND_IN_H

#include <LinearMath/btVector3.h>

#include <cstdint>
#include <vector>

struct qcBreakingMesh
{
    std::vector<btVector3> vertices;
    std::vector<uint32_t> indices; ///< three a triangle, counterclockwise as seen from outside
};

/// A scaly serpent's knot that stands on y = 0.
qcBreakingMesh qcStandInDragon(uint32_t triangles, double length);
/// A lumpy ball that stands on y = 0.
qcBreakingMesh qcStandInBunny(uint32_t triangles, double length);

#endif
