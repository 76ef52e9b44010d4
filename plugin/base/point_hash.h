// A hash of positions, for tables of points.
#ifndef QC_BASE_POINT_HASH_H
#define QC_BASE_POINT_HASH_H

#include <stdint.h>
#include <string.h>

/// Equal points have equal hashes; -0 equals +0. The low bits are well mixed.
static inline uint64_t qcPointHash_Of(uint64_t seed, double x, double y, double z)
{
    const double coordinates[3] = {x + 0.0, y + 0.0, z + 0.0}; // -0 becomes +0
    uint64_t hash = seed;
    for (int axis = 0; axis < 3; axis++)
    {
        uint64_t bits;
        memcpy(&bits, &coordinates[axis], sizeof bits);
        hash = (hash ^ bits) * 0x9e3779b97f4a7c15ULL;
        hash ^= hash >> 32;
    }
    return hash;
}

#endif
