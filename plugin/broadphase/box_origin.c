// Boxes of floats relative to an origin, and the choice of the origin from a sample of boxes.
#include "broadphase/box_origin.h"

#include "base/sort_numbers.h"

#include <math.h>

void qcBoxOrigin_EncloseFrom(const qcBoxOrigin* origin, qcFloatBox* box, const double lower[3], const double upper[3])
{
    qcBounds relative;
    for (int k = 0; k < 3; k++)
    {
        // The difference is rounded within 2^-53 of its size, or exact where it is subnormal. A factor instead of a
        // sum, because infinity stays infinity.
        double low = lower[k] - origin->at[k], high = upper[k] - origin->at[k];
        relative.lower[k] = low * (low > 0.0 ? 1.0 - 0x1p-52 : 1.0 + 0x1p-52);
        relative.upper[k] = high * (high > 0.0 ? 1.0 + 0x1p-52 : 1.0 - 0x1p-52);
    }
    (void)qcFloatBox_Enclose(box, relative.lower, relative.upper);
}

static bool IsCoarse(const qcBoxOrigin* origin, const qcBounds* bounds)
{
    qcFloatBox box;
    (void)qcBoxOrigin_Enclose(origin, &box, bounds->lower, bounds->upper);
    return qcFloatBox_IsCoarse(&box, bounds->lower, bounds->upper);
}

/// The median of centres in one axis.
static double MedianCenter(const qcBounds* boxes, uint32_t count, int k)
{
    double centers[qc_originSample] = {0.0};
    for (uint32_t i = 0; i < count; i++)
        centers[i] = 0.5 * boxes[i].lower[k] + 0.5 * boxes[i].upper[k];
    qcSortNumbers(centers, count);
    return centers[count / 2];
}

bool qcBoxOrigin_Choose(qcBoxOrigin* origin, const qcBounds* sample, uint32_t count)
{
    qcBounds coarse[qc_originSample];
    uint32_t coarseCount = 0;
    for (uint32_t i = 0; i < count; i++)
        if (IsCoarse(origin, &sample[i]))
            coarse[coarseCount++] = sample[i];
    if (coarseCount == 0 || 2 * coarseCount < count)
        return false;
    qcBoxOrigin next = {.isSet = true};
    for (int k = 0; k < 3; k++)
    {
        next.at[k] = MedianCenter(coarse, coarseCount, k);
        // Less than half the spacing of the largest doubles: no difference of finite numbers overflows.
        if (!(fabs(next.at[k]) <= 0x1p960))
            return false;
    }
    uint32_t left = 0;
    for (uint32_t i = 0; i < count; i++)
        left += IsCoarse(&next, &sample[i]);
    if (4 * left > coarseCount)
        return false;
    *origin = next;
    return true;
}
