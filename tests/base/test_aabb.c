// Boxes: of vertices, for every count and for both types, against each number compared with the others; united, and
// tested for distance and overlap.
#include "base/aabb.h"
#include "support/soups.h"
#include "support/suite.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum
{
    qc_maxVertices = 41
};

static void CheckBox(const double* positions, size_t count, const double lower[3], const double upper[3])
{
    for (size_t axis = 0; axis < 3; axis++)
    {
        double min = 0.25, max = 0.25; // the box before
        for (size_t v = 0; v < count; v++)
        {
            min = fmin(min, positions[3 * v + axis]);
            max = fmax(max, positions[3 * v + axis]);
        }
        ck_assert(lower[axis] == min && upper[axis] == max);
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

START_TEST(an_empty_box_becomes_what_it_is_extended_by)
{
    const double lower[3] = {-1.0, 2.0, DBL_MAX}, upper[3] = {0.0, 2.0, DBL_MAX}, point[3] = {-2.0, 2.5, -DBL_MAX};
    qcBounds box;
    qcBounds_Clear(box.lower, box.upper);
    qcBounds_IncludeBox(box.lower, box.upper, box.lower, box.upper);
    ck_assert(box.lower[0] > box.upper[0]);
    qcBounds_IncludeBox(lower, upper, box.lower, box.upper);
    ck_assert(memcmp(box.lower, lower, sizeof lower) == 0 && memcmp(box.upper, upper, sizeof upper) == 0);
    qcBounds_IncludePoint(point, box.lower, box.upper);
    ck_assert(box.lower[0] == -2.0 && box.upper[0] == 0.0);
    ck_assert(box.lower[1] == 2.0 && box.upper[1] == 2.5);
    ck_assert(box.lower[2] == -DBL_MAX && box.upper[2] == DBL_MAX);
}
END_TEST

START_TEST(boxes_are_near_and_overlap_by_all_axes)
{
    for (int axis = 0; axis < 3; axis++)
        for (int order = 0; order < 2; order++)
        {
            qcBounds boxes[2] = {{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}}, {{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}}};
            const qcBounds *a = &boxes[order], *b = &boxes[1 - order];
            boxes[1].lower[axis] = 1.0;
            ck_assert(qcBounds_Overlap(a, b) && qcBounds_AreNear(a->lower, a->upper, b->lower, b->upper, 0.0));
            boxes[1].lower[axis] = boxes[1].upper[axis] = 1.5;
            ck_assert(!qcBounds_Overlap(a, b) && !qcBounds_AreNear(a->lower, a->upper, b->lower, b->upper, 0.25));
            ck_assert(qcBounds_AreNear(a->lower, a->upper, b->lower, b->upper, 0.5));
        }
}
END_TEST

QC_RUN_TESTS("boxes", a_box_is_extended_by_every_vertex, an_empty_box_becomes_what_it_is_extended_by,
             boxes_are_near_and_overlap_by_all_axes)
