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

static inline uint32_t MaskOf(const FourInts halves[2])
{
    const FourInts weights[2] = {{1, 2, 4, 8}, {16, 32, 64, 128}};
    FourInts bits = (halves[0] & weights[0]) | (halves[1] & weights[1]);
    return (uint32_t)(bits[0] | bits[1] | bits[2] | bits[3]);
}

static inline uint32_t OverlapLanes(const Lanes* lanes, const qcFloatBox* box)
{
    FourInts overlap[2];
    for (int half = 0; half < 2; half++)
    {
        overlap[half] = (FourInts){-1, -1, -1, -1};
        for (int k = 0; k < 3; k++)
            overlap[half] &= (lanes->lower[k][half] <= box->upper[k]) & (lanes->upper[k][half] >= box->lower[k]);
    }
    return MaskOf(overlap);
}

static inline FourFloats LoadFour(const float* at)
{
    FourFloats four;
    memcpy(&four, at, sizeof four);
    return four;
}

/// a where the mask is set, otherwise b.
static inline FourFloats Select(FourInts mask, FourFloats a, FourFloats b)
{
    return (FourFloats)((mask & (FourInts)a) | (~mask & (FourInts)b));
}

static inline uint32_t CastLanes(const qcOctet* octet, const qcFloatCast* cast, float fraction, float entries[qc_lanes])
{
    FourInts hit[2];
    for (int half = 0; half < 2; half++)
    {
        FourFloats enter = {0, 0, 0, 0}, leave = enter + fraction;
        for (int k = 0; k < 3; k++)
        {
            if (cast->inverse[k] == 0.0f)
                continue;
            FourFloats low = (LoadFour(&octet->lower[k][4 * half]) - cast->lowerOffset[k]) * cast->inverse[k];
            FourFloats high = (LoadFour(&octet->upper[k][4 * half]) - cast->upperOffset[k]) * cast->inverse[k];
            FourFloats near = cast->inverse[k] > 0.0f ? low : high, far = cast->inverse[k] > 0.0f ? high : low;
            enter = Select(near > enter, near, enter);
            leave = Select(far < leave, far, leave);
        }
        FourFloats entry = enter * (1.0f - QC_FLOAT_CAST_TOLERANCE);
        memcpy(entries + 4 * half, &entry, sizeof entry);
        hit[half] = ~(enter > leave + QC_FLOAT_CAST_TOLERANCE);
    }
    return MaskOf(hit);
}

#include "broadphase/box_kernels.inl.h"

const qcBoxKernels qcBoxKernels_scalar = {Overlap, CastOctet, FindOverlaps};
