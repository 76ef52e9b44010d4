// Positions in floats: copied, bounded, and refused if one number is not finite, for every count and place.
#include "scene/vertex_input.h"
#include "support/soups.h"
#include "support/suite.h"

#include <float.h>
#include <math.h>

enum
{
    qc_maxVertices = 41
};

static void CheckBox(const float* positions, size_t count, const double lower[3], const double upper[3])
{
    for (size_t axis = 0; axis < 3; axis++)
    {
        double least = 0.25, most = 0.25; // the box before
        for (size_t v = 0; v < count; v++)
        {
            least = fmin(least, (double)positions[3 * v + axis]);
            most = fmax(most, (double)positions[3 * v + axis]);
        }
        ck_assert(lower[axis] == least && upper[axis] == most);
    }
}

/// Copies vertices `stride` floats apart. Returns whether all are finite.
static bool Copy(const float* positions, size_t count, size_t stride, float* out, double lower[3], double upper[3])
{
    const qcVertexInput input = {positions, qc_positionF32, stride * sizeof(float), (uint32_t)count};
    for (int axis = 0; axis < 3; axis++)
        lower[axis] = upper[axis] = 0.25;
    return qcVertexInput_ReadFloats(&input, out, lower, upper);
}

START_TEST(every_float_is_copied_and_checked)
{
    static const float bads[] = {NAN, -NAN, INFINITY, -INFINITY};
    qcRandom random = {13};
    for (size_t stride = 3; stride < 5; stride++)
        for (size_t count = 0; count <= qc_maxVertices; count++)
        {
            float floats[4 * qc_maxVertices] = {0.0f}, copy[3 * qc_maxVertices];
            double lower[3], upper[3];
            for (size_t v = 0; v < count; v++)
                for (size_t axis = 0; axis < 3; axis++)
                    floats[stride * v + axis] =
                        qcRandom_Below(&random, 20) == 0 ? FLT_MAX : (float)qcRandom_Uniform(&random, -1.0, 1.0);
            ck_assert(Copy(floats, count, stride, copy, lower, upper));
            for (size_t i = 0; i < 3 * count; i++)
                ck_assert(copy[i] == floats[stride * (i / 3) + i % 3]);
            CheckBox(copy, count, lower, upper);
            for (size_t i = 0; i < 12 * count; i++)
            {
                float* at = &floats[stride * (i / 12) + i / 4 % 3];
                float good = *at;
                *at = bads[i % 4];
                ck_assert(!Copy(floats, count, stride, copy, lower, upper));
                *at = good;
            }
        }
}
END_TEST

QC_RUN_TESTS("positions in floats", every_float_is_copied_and_checked)
