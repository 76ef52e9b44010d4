// The box of vertices is that of each number compared with the others, for every count and for both types; where
// positions are copied, too.
#include "base/aabb.h"
#include "scene/vertex_input.h"
#include "support/soups.h"
#include "support/suite.h"

#include <float.h>
#include <math.h>

enum
{
    qc_maxVertices = 41
};

static void CheckBox(const double* positions, size_t count, const double lower[3], const double upper[3])
{
    for (size_t axis = 0; axis < 3; axis++)
    {
        double least = 0.25, most = 0.25; // the box before
        for (size_t v = 0; v < count; v++)
        {
            least = fmin(least, positions[3 * v + axis]);
            most = fmax(most, positions[3 * v + axis]);
        }
        ck_assert(lower[axis] == least && upper[axis] == most);
    }
}

START_TEST(a_box_is_extended_by_every_vertex)
{
    static const double specials[] = {FLT_MAX, -FLT_MAX, FLT_TRUE_MIN, -FLT_MIN, 0.0, -0.0};
    qcRandom random = {11};
    for (int round = 0; round < 300; round++)
        for (size_t count = 0; count <= qc_maxVertices; count++)
        {
            double doubles[3 * qc_maxVertices + 1];
            float floats[3 * qc_maxVertices + 1];
            for (size_t i = 0; i < 3 * count; i++)
            {
                double x = qcRandom_Uniform(&random, -1.0, 1.0);
                floats[i] = (float)(qcRandom_Below(&random, 20) == 0 ? specials[qcRandom_Below(&random, 6)] : x);
                doubles[i] = (double)floats[i];
            }
            // One behind the end.
            floats[3 * count] = FLT_MAX;
            doubles[3 * count] = DBL_MAX;
            double lower[2][3], upper[2][3];
            for (int i = 0; i < 6; i++)
                lower[i / 3][i % 3] = upper[i / 3][i % 3] = 0.25;
            qcBounds_Include(doubles, count, lower[0], upper[0]);
            qcBounds_IncludeFloats(floats, count, lower[1], upper[1]);
            CheckBox(doubles, count, lower[0], upper[0]);
            CheckBox(doubles, count, lower[1], upper[1]);
        }
}
END_TEST

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
            double doubles[3 * qc_maxVertices], lower[3], upper[3];
            for (size_t i = 0; i < 3 * count; i++)
            {
                float x = (float)qcRandom_Uniform(&random, -1.0, 1.0);
                x = qcRandom_Below(&random, 20) == 0 ? FLT_MAX : x;
                floats[stride * (i / 3) + i % 3] = x;
                doubles[i] = (double)x;
            }
            ck_assert(Copy(floats, count, stride, copy, lower, upper));
            CheckBox(doubles, count, lower, upper);
            for (size_t i = 0; i < 3 * count; i++)
                ck_assert((double)copy[i] == doubles[i]);
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

QC_RUN_TESTS("bounds of vertices", a_box_is_extended_by_every_vertex, every_float_is_copied_and_checked)
