// Outliers are found by quartiles of the sample.
#include "mesh/triangle_sample.h"

#include "base/sort_numbers.h"

#include <string.h>

enum
{
    // Fewer triangles have at most some thousand pairs.
    qc_minSampled = 16,
    qc_minStride = 4,
    // One in so many of the sample is left out at each end of an axis: quartiles.
    qc_trimmedShare = 4,
    // A box that is not so many times as large as most of the mesh is kept: numbers for all of it are fine enough.
    qc_minReduction = 8
};

uint32_t qcTriangleSample_Count(uint32_t triangleCount)
{
    uint32_t count = triangleCount / qc_minStride;
    return count < qc_minSampled ? 0 : count < qc_maxSampled ? count : qc_maxSampled;
}

void qcTriangleSample_Take(qcTriangleSample* sample, const uint32_t* indices, uint32_t triangleCount,
                           const double* positions)
{
    sample->count = qcTriangleSample_Count(triangleCount);
    for (uint32_t i = 0; i < sample->count; i++)
    {
        size_t triangle = (size_t)(2 * i + 1) * triangleCount / (2 * sample->count);
        for (size_t c = 0; c < 3; c++)
            memcpy(sample->corners[i][c], positions + 3 * (size_t)indices[3 * triangle + c], 3 * sizeof(double));
    }
}

double qcTriangleSample_MedianSize(const qcTriangleSample* sample)
{
    double sizes[qc_maxSampled];
    for (uint32_t i = 0; i < sample->count; i++)
    {
        double lower[3], upper[3];
        qcBounds_OfTriangle(sample->corners[i], lower, upper);
        sizes[i] = qcBounds_Widest(lower, upper);
    }
    qcSortNumbers(sizes, sample->count);
    return sample->count != 0 ? sizes[sample->count / 2] : 0.0;
}

bool qcTriangleSample_Trim(const qcTriangleSample* sample, double lower[3], double upper[3])
{
    if (sample->count == 0 || !qcBounds_AreWide(lower, upper, qcTriangleSample_MedianSize(sample)))
        return false;
    double low[3], high[3], numbers[qc_maxSampled];
    uint32_t trimmed = sample->count / qc_trimmedShare;
    for (int axis = 0; axis < 3; axis++)
    {
        for (uint32_t i = 0; i < sample->count; i++)
            numbers[i] = sample->corners[i][0][axis];
        qcSortNumbers(numbers, sample->count);
        low[axis] = numbers[trimmed];
        high[axis] = numbers[sample->count - 1 - trimmed];
    }
    // Room for what was left out although it is close.
    double room = qcBounds_Widest(low, high);
    for (int axis = 0; axis < 3; axis++)
    {
        low[axis] = fmax(low[axis] - room, lower[axis]);
        high[axis] = fmin(high[axis] + room, upper[axis]);
    }
    double widest = qcBounds_Widest(low, high);
    if (!(widest > 0.0 && qc_minReduction * widest < qcBounds_Widest(lower, upper)))
        return false;
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = low[axis];
        upper[axis] = high[axis];
    }
    return true;
}
