// A hash of positions.
#ifndef QC_MANIFOLD_POSITION_HASH_H
#define QC_MANIFOLD_POSITION_HASH_H

#include "base/vec3.h"

#include <string.h>

/// Equal positions have one hash: 0 and -0 too.
static inline uint64_t qcPositionHash_Of(uint64_t seed, qcVector position)
{
    const double coordinates[3] = {position.x, position.y, position.z};
    for (int axis = 0; axis < 3; axis++)
    {
        double x = coordinates[axis] + 0.0; // -0 becomes +0
        uint64_t bits;
        memcpy(&bits, &x, sizeof bits);
        seed = (seed ^ bits) * 0x9e3779b97f4a7c15ULL;
        seed ^= seed >> 32;
    }
    return seed;
}

#endif
