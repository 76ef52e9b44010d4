// A patch that the kernels of every instruction set prove flat over a motion has no self-contact at any sampled time,
// by the exact test; and patches that bend and turn little are proven flat.
#include "kernels/patches.h"
#include "quickcullide/scene.h"
#include "support/suite.h"

#include <stdio.h>

enum
{
    // Times k / 16. Positions are multiples of 2^-46, so that those at these times are exact in double.
    qc_times = 16
};

/// At the start and at the end. The scales apply to both points and positions.
typedef struct Motion
{
    qcPatch at[2];
    float scales[2];
} Motion;

static bool IsFlat(const qcTriangleKernels* k, const Motion* motion)
{
    qcPatchGeometry geometry[2];
    for (int t = 0; t < 2; t++)
    {
        const qcPatch* patch = &motion->at[t];
        geometry[t] = (qcPatchGeometry){.corners = patch->corners,
                                        .points = patch->points,
                                        .slots = patch->slots,
                                        .loop = patch->loop,
                                        .slotCount = patch->triangleCount,
                                        .loopCount = patch->loopCount,
                                        .pointError = patch->pointError};
    }
    return k->isPatchFlatInMotion(geometry, motion->scales);
}

static bool ShareVertex(const qcCorners* a, const qcCorners* b)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            if (a->vertex[i] == b->vertex[k])
                return true;
    return false;
}

static bool AreBoxesApart(double (*const a[3])[3], double (*const b[3])[3])
{
    for (int i = 0; i < 3; i++)
    {
        double p[3] = {(*a[0])[i], (*a[1])[i], (*a[2])[i]}, q[3] = {(*b[0])[i], (*b[1])[i], (*b[2])[i]};
        if (fmin(p[0], fmin(p[1], p[2])) > fmax(q[0], fmax(q[1], q[2])) ||
            fmin(q[0], fmin(q[1], q[2])) > fmax(p[0], fmax(p[1], p[2])))
            return true;
    }
    return false;
}

/// Two triangles without a common vertex meet at time k / 16.
static bool MeetsItself(const Motion* motion, int k)
{
    double x[qc_patchVertices][3];
    const qcPatch *start = &motion->at[0], *end = &motion->at[1];
    for (uint32_t v = 0; v < start->vertexCount; v++)
        for (int i = 0; i < 3; i++)
            x[v][i] = (qc_times - k) * (double)motion->scales[0] * start->positions[v][i] +
                      k * (double)motion->scales[1] * end->positions[v][i];
    for (uint32_t t = 0; t < start->triangleCount; t++)
        for (uint32_t u = t + 1; u < start->triangleCount; u++)
        {
            const uint32_t *p = start->corners[t].vertex, *q = start->corners[u].vertex;
            double(*const a[3])[3] = {&x[p[0]], &x[p[1]], &x[p[2]]};
            double(*const b[3])[3] = {&x[q[0]], &x[q[1]], &x[q[2]]};
            if (ShareVertex(&start->corners[t], &start->corners[u]) || AreBoxesApart(a, b))
                continue;
            double first[3][3], second[3][3];
            for (int c = 0; c < 3; c++)
            {
                memcpy(first[c], *a[c], sizeof first[c]);
                memcpy(second[c], *b[c], sizeof second[c]);
            }
            if (qcRelateTriangles(first[0], second[0]) != qc_relationDisjoint)
                return true;
        }
    return false;
}

typedef struct Counts
{
    int all, flat, meet;
} Counts;

static void CheckMotion(const Motion* motion, Counts* counts, const char* what)
{
    bool isProven[qc_maxKernels] = {false}, any = false;
    FOR_EACH_KERNELS(k)
    {
        isProven[kernelIndex] = IsFlat(k, motion);
        any = any || isProven[kernelIndex];
    }
    bool meets = false;
    for (int time = 0; time <= qc_times && !meets; time++)
        meets = MeetsItself(motion, time);
    FOR_EACH_KERNELS(k)
    CHECK_THAT(!isProven[kernelIndex] || !meets, "%s: %s is called flat", k->name, what);
    counts->all++;
    counts->flat += any;
    counts->meet += meets;
}

//  ---- motions -----------------------------------------------------------------------------------------------------

/// Coordinates in the plane of the patch and above it, before it is placed.
static void MakePlane(qcRandom* random, int i, qcPatch* patch)
{
    double height = qcRandom_Below(random, 2) == 0 ? 0.0 : qcRandom_Uniform(random, 0.0, 0.3);
    switch (i % 3)
    {
        case 0:
            qcPatch_MakePath(random, (qcStripKind)(i / 3 % qc_stripKindCount), 2 + qcRandom_Below(random, 11),
                             i % 2 == 0 ? 0.0 : 0.3, 0.1, height, patch);
            break;
        case 1: qcPatch_MakeGrown(random, 4 + qcRandom_Below(random, 20), 0.4, height, patch); break;
        default: qcPatch_MakeTeeth(random, 2 + qcRandom_Below(random, 5), 0.5 + ldexp(0.1, -i / 3 % 7), height, patch);
    }
}

/// The end: turned in its plane, tilted, sheared, with displaced vertices.
static void MoveInPlane(qcRandom* random, const qcPatch* from, qcPatch* to)
{
    double noise = qcRandom_Below(random, 2) == 0 ? 0.0 : ldexp(1.0, -(int)qcRandom_Below(random, 10));
    double angle =
        qcRandom_Below(random, 3) == 0 ? qcRandom_Uniform(random, -3.2, 3.2) : qcRandom_Uniform(random, -0.6, 0.6);
    double tilt = qcRandom_Below(random, 3) == 0 ? qcRandom_Uniform(random, -2.0, 2.0) : 0.0;
    double shear = qcRandom_Below(random, 3) == 0 ? qcRandom_Uniform(random, -2.0, 2.0) : 0.0;
    *to = *from;
    for (uint32_t v = 0; v < to->vertexCount; v++)
    {
        double *p = to->positions[v], x = p[0] + shear * p[1] + qcRandom_Uniform(random, -noise, noise),
               y = p[1] + qcRandom_Uniform(random, -noise, noise),
               z = p[2] + qcRandom_Uniform(random, -noise, noise) + tilt * x;
        p[0] = cos(angle) * x - sin(angle) * y;
        p[1] = sin(angle) * x + cos(angle) * y;
        p[2] = z;
    }
}

static void RoundPositions(qcPatch* patch)
{
    for (uint32_t v = 0; v < patch->vertexCount; v++)
        for (int i = 0; i < 3; i++)
            patch->positions[v][i] = floor(patch->positions[v][i] * 0x1p46) * 0x1p-46;
}

static void MakeMotion(qcRandom* random, int i, Motion* motion)
{
    MakePlane(random, i, &motion->at[0]);
    if (qcRandom_Below(random, 8) != 0)
        MoveInPlane(random, &motion->at[0], &motion->at[1]);
    else
    {
        // Another shape of the same strip, or the mirror image.
        motion->at[1] = motion->at[0];
        for (uint32_t v = 0; v < motion->at[1].vertexCount; v++)
            motion->at[1].positions[v][qcRandom_Below(random, 200) == 0 ? 1 : 0] *= -1.0;
    }
    bool ofAxes = qcRandom_Below(random, 2) == 0;
    uint64_t seed = qcRandom_Next(random);
    double sizes[2] = {qcRandom_Uniform(random, 0.3, 0.9), qcRandom_Uniform(random, 0.3, 0.9)};
    for (int t = 0; t < 2; t++)
    {
        // The same directions at both ends.
        qcRandom same = {seed};
        double error = i / 3 % 3 == 2 ? ldexp(1.0, -8 - (int)qcRandom_Below(random, 16)) : 0.0;
        qcPatch_Place(&motion->at[t], &same, ofAxes, sizes[t], error);
        RoundPositions(&motion->at[t]);
        motion->scales[t] = 1.0f;
    }
    if (qcRandom_Below(random, 4) == 0)
        motion->scales[qcRandom_Below(random, 2)] = ldexpf(1.0f, -(int)qcRandom_Below(random, 4));
}

//  ---- tests -------------------------------------------------------------------------------------------------------

START_TEST(a_patch_that_stays_flat_never_meets_itself)
{
    qcRandom random = {51 + (uint64_t)_i};
    Counts counts = {0};
    int count = qcGetTestPairCount(4000);
    for (int i = 0; i < count; i++)
    {
        Motion motion;
        MakeMotion(&random, 3 * i + _i, &motion);
        char what[64];
        snprintf(what, sizeof what, "motion %d of kind %d", i, _i);
        CheckMotion(&motion, &counts, what);
    }
    printf("kind %d: %d motions, %d flat, %d meet themselves\n", _i, counts.all, counts.flat, counts.meet);
    ck_assert_int_gt(counts.flat, count / 10);
    ck_assert_int_gt(counts.meet, count / 50);
}
END_TEST

START_TEST(a_patch_that_turns_and_bends_a_little_is_flat)
{
    qcRandom random = {61};
    for (int i = 0; i < 300; i++)
    {
        Motion motion;
        qcPatch* patch = motion.at;
        qcPatch_MakeStrip(&patch[0], qc_patchColumns);
        for (uint32_t c = 0; c <= qc_patchColumns; c++)
            for (uint32_t r = 0; r <= qc_patchRows; r++)
            {
                double* x = patch[0].positions[qcPatch_Vertex(c, r)];
                x[0] = c + qcRandom_Uniform(&random, -0.1, 0.1);
                x[1] = r + qcRandom_Uniform(&random, -0.1, 0.1);
                x[2] = 0.3 * sin(0.4 * c + i);
            }
        patch[1] = patch[0];
        double angle = qcRandom_Uniform(&random, -1.0, 1.0);
        for (uint32_t v = 0; v < patch[1].vertexCount; v++)
        {
            double *p = patch[1].positions[v], x = p[0], y = p[1];
            p[0] = cos(angle) * x - sin(angle) * y;
            p[1] = sin(angle) * x + cos(angle) * y;
            p[2] = 0.3 * sin(0.5 * x + 2 * i);
        }
        for (int t = 0; t < 2; t++)
        {
            qcRandom same = {1000 + (uint64_t)i};
            qcPatch_Place(&patch[t], &same, i % 2 == 0, 0.9, 0.0);
            motion.scales[t] = 1.0f;
        }
        FOR_EACH_KERNELS(k)
        CHECK_THAT(IsFlat(k, &motion), "%s: motion %d is not flat", k->name, i);
    }
}
END_TEST

int main(void)
{
    Suite* suite = suite_create("flat_patch_motion");
    TCase* tests = tcase_create("motions");
    tcase_set_timeout(tests, 0);
    tcase_add_loop_test(tests, a_patch_that_stays_flat_never_meets_itself, 0, 3);
    tcase_add_test(tests, a_patch_that_turns_and_bends_a_little_is_flat);
    suite_add_tcase(suite, tests);
    return qcRunSuite(suite);
}
