// The box of vertices is that of each number compared with the others, for every count and for both types.
#include "base/aabb.h"
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

QC_RUN_TESTS("bounds of vertices", a_box_is_extended_by_every_vertex)
