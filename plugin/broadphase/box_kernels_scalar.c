// Box kernels in plain C, for any processor, with the compiler's vectors.
#include "broadphase/box_kernels.h"

#include <string.h>

typedef float FourFloats __attribute__((vector_size(16)));
typedef int32_t FourInts __attribute__((vector_size(16)));

typedef struct Lanes
{
    FourFloats lower[3][2], upper[3][2];
} Lanes;

static inline Lanes LoadLanes(const qcOctet* octet)
{
    Lanes lanes;
    memcpy(lanes.lower, octet->lower, sizeof lanes.lower);
    memcpy(lanes.upper, octet->upper, sizeof lanes.upper);
    return lanes;
}

static inline uint32_t OverlapLanes(const Lanes* lanes, const qcFloatBox* box)
{
    const FourInts weights[2] = {{1, 2, 4, 8}, {16, 32, 64, 128}};
    FourInts overlap[2];
    for (int half = 0; half < 2; half++)
    {
        overlap[half] = weights[half];
        for (int k = 0; k < 3; k++)
            overlap[half] &= (lanes->lower[k][half] <= box->upper[k]) & (lanes->upper[k][half] >= box->lower[k]);
    }
    overlap[0] |= overlap[1];
    return (uint32_t)(overlap[0][0] | overlap[0][1] | overlap[0][2] | overlap[0][3]);
}

#include "broadphase/box_kernels.inl.h"

const qcBoxKernels qcBoxKernels_scalar = {Overlap, FindOverlaps};
