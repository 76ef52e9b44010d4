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

typedef enum MotionKind
{
    qc_motionOfStrip,
    qc_motionOfGrown,
    qc_motionOfTeeth,
    qc_motionUnrelated,  ///< the ends are two strips or rows of teeth that are both flat
    qc_motionOfTwoTeeth, ///< likewise: a strip with two teeth whose tips are anywhere
    qc_motionOfMouth,    ///< likewise: a fan with a notch, and one triangle more on both sides of it
    qc_motionTwist,      ///< rings that turn against each other
    qc_motionKindCount
} MotionKind;

/// Strips and rows of teeth of one number of columns have one topology.
static void MakeStripOrTeeth(qcRandom* random, bool teeth, uint32_t columns, double height, qcPatch* patch)
{
    qcStripKind kind = (qcStripKind)qcRandom_Below(random, qc_stripKindCount);
    double notch = qcRandom_Below(random, 2) == 0 ? 0.0 : 0.3;
    if (teeth)
        qcPatch_MakeTeeth(random, columns / 2, qcRandom_Uniform(random, -0.3, 1.2), height, patch);
    else
        qcPatch_MakePath(random, kind, columns, notch, 0.1, height, patch);
}

enum
{
    qc_rings = 5,
    qc_ringVertices = 6
};

/// A centre and rings around it, each three times as wide as the one within.
static void MakeRings(qcPatch* patch)
{
    *patch = (qcPatch){.vertexCount = 1 + qc_rings * qc_ringVertices, .loopCount = qc_ringVertices};
    for (uint32_t r = 0; r < qc_rings; r++)
        for (uint32_t i = 0; i < qc_ringVertices; i++)
        {
            uint32_t next = (i + 1) % qc_ringVertices, first = 1 + r * qc_ringVertices, inner = first - qc_ringVertices;
            double angle = 6.283185307179586 * i / qc_ringVertices, radius = pow(3.0, r);
            patch->positions[first + i][0] = radius * cos(angle);
            patch->positions[first + i][1] = radius * sin(angle);
            qcPatch_AddTriangle(patch, r == 0 ? 0 : inner + i, first + i, first + next);
            if (r > 0)
                qcPatch_AddTriangle(patch, inner + i, first + next, inner + next);
            patch->loop[i] = first + i;
        }
}

/// Turns each ring against the one around it. The last one stays.
static void Twist(qcRandom* random, const qcPatch* from, qcPatch* to)
{
    double angle = 0.0, most = qcRandom_Uniform(random, 0.1, 1.3);
    *to = *from;
    for (uint32_t r = qc_rings - 1; r-- > 0;)
    {
        angle += most * qcRandom_Uniform(random, 0.8, 1.0);
        for (uint32_t v = 1 + r * qc_ringVertices; v < 1 + (r + 1) * qc_ringVertices; v++)
        {
            double *p = to->positions[v], x = p[0], y = p[1];
            p[0] = cos(angle) * x - sin(angle) * y;
            p[1] = sin(angle) * x + cos(angle) * y;
        }
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

/// Places both ends in the same directions.
static void Place(qcRandom* random, double error, Motion* motion)
{
    bool ofAxes = qcRandom_Below(random, 2) == 0;
    uint64_t seed = qcRandom_Next(random);
    double sizes[2] = {qcRandom_Uniform(random, 0.3, 0.9), qcRandom_Uniform(random, 0.3, 0.9)};
    for (int t = 0; t < 2; t++)
    {
        qcRandom same = {seed};
        qcPatch_Place(&motion->at[t], &same, ofAxes, sizes[t], error);
        RoundPositions(&motion->at[t]);
        motion->scales[t] = 1.0f;
    }
    if (qcRandom_Below(random, 4) == 0)
        motion->scales[qcRandom_Below(random, 2)] = ldexpf(1.0f, -(int)qcRandom_Below(random, 4));
}

/// With the largest errors of points for which the motion is proven flat.
static void PlaceWithErrors(qcRandom* random, Motion* motion)
{
    const Motion plane = *motion;
    const qcRandom start = *random;
    for (double error = 0x1p-6; error > 0x1p-18; error /= 1.3)
    {
        *random = start;
        *motion = plane;
        Place(random, error, motion);
        if (IsFlat(&qcTriangleKernels_scalar, motion))
            return;
    }
}

/// Flat where it is, in its own plane.
static bool IsFlatInPlane(const qcPatch* patch)
{
    qcPatch placed = *patch;
    qcRandom random = {1};
    qcPatch_Place(&placed, &random, true, 0.9, 0.0);
    const Motion still = {{placed, placed}, {1.0f, 1.0f}};
    return IsFlat(&qcTriangleKernels_scalar, &still);
}

/// A strip of squares with teeth on two of them.
static void MakeTwoTeeth(qcRandom* random, uint32_t columns, const uint32_t at[2], qcPatch* patch)
{
    uint32_t count = columns + 1, loopAt = 0;
    *patch = (qcPatch){.vertexCount = 2 * count + 2};
    for (uint32_t v = 0; v < 2 * count; v++)
    {
        patch->positions[v][0] = v % count + qcRandom_Uniform(random, -0.1, 0.1);
        patch->positions[v][1] = v < count ? -1.0 : 0.0;
    }
    for (uint32_t i = 0; i < 2; i++)
    {
        double* tip = patch->positions[2 * count + i];
        tip[0] = 0.5 * (at[0] + at[1] + 1.0) + qcRandom_Uniform(random, -2.0, 2.0);
        tip[1] = qcRandom_Uniform(random, 0.1, 3.0);
        qcPatch_AddTriangle(patch, count + at[i], count + at[i] + 1, 2 * count + i);
    }
    for (uint32_t c = 0; c < columns; c++)
    {
        qcPatch_AddTriangle(patch, c, c + 1, count + c);
        qcPatch_AddTriangle(patch, c + 1, count + c + 1, count + c);
    }
    for (uint32_t c = 0; c < count; c++)
        patch->loop[loopAt++] = c;
    for (uint32_t c = count; c-- > 0;)
    {
        patch->loop[loopAt++] = count + c;
        for (uint32_t i = 0; i < 2; i++)
            if (c == at[i] + 1)
                patch->loop[loopAt++] = 2 * count + i;
    }
    patch->loopCount = loopAt;
}

/// Vertices 1 to 6 around vertex 0; vertices 7 and 8 beyond both ends.
static void MakeMouth(qcRandom* random, qcPatch* patch)
{
    static const uint32_t loop[] = {0, 1, 7, 2, 3, 4, 5, 8, 6};
    *patch = (qcPatch){.vertexCount = 9, .loopCount = 9};
    double open = qcRandom_Uniform(random, 0.02, 0.5), turn = qcRandom_Uniform(random, -0.7, 0.7), spread = turn;
    for (uint32_t i = 1; i <= 6; i++)
    {
        double radius = i == 1 || i == 6 ? pow(2.0, qcRandom_Uniform(random, -2.0, 2.0)) : 1.5;
        spread = turn + open / 2.0 + (6.283185307179586 - open) * (i - 1) / 5.0;
        patch->positions[i][0] = radius * cos(spread);
        patch->positions[i][1] = radius * sin(spread);
        if (i < 6)
            qcPatch_AddTriangle(patch, 0, i, i + 1);
    }
    for (uint32_t i = 0; i < 2; i++)
        for (int axis = 0; axis < 2; axis++)
            patch->positions[7 + i][axis] =
                patch->positions[i == 0 ? 1 : 6][axis] * qcRandom_Uniform(random, 1.0, 1.5) +
                0.3 * patch->positions[i == 0 ? 2 : 5][axis];
    qcPatch_AddTriangle(patch, 1, 7, 2);
    qcPatch_AddTriangle(patch, 5, 8, 6);
    memcpy(patch->loop, loop, sizeof loop);
}

/// Both ends are flat, and have nothing but their topology in common.
static void MakeUnrelated(qcRandom* random, MotionKind kind, Motion* motion)
{
    bool teeth = qcRandom_Below(random, 2) == 0;
    uint32_t columns = 4 + qcRandom_Below(random, kind == qc_motionUnrelated ? 12 : 5);
    uint32_t first = qcRandom_Below(random, columns - 3);
    const uint32_t at[2] = {first, first + 2 + qcRandom_Below(random, columns - first - 2)};
    for (int t = 0; t < 2; t++)
        do
            if (kind == qc_motionOfTwoTeeth)
                MakeTwoTeeth(random, columns, at, &motion->at[t]);
            else if (kind == qc_motionOfMouth)
                MakeMouth(random, &motion->at[t]);
            else
                MakeStripOrTeeth(random, teeth, columns, 0.0, &motion->at[t]);
        while (!IsFlatInPlane(&motion->at[t]));
}

static void MakeMotion(qcRandom* random, MotionKind kind, Motion* motion)
{
    qcPatch *start = &motion->at[0], *end = &motion->at[1];
    double height = qcRandom_Below(random, 2) == 0 ? 0.0 : qcRandom_Uniform(random, 0.0, 0.3);
    bool hasErrors = kind != qc_motionTwist && qcRandom_Below(random, 2) == 0;
    switch (kind)
    {
        case qc_motionUnrelated:
        case qc_motionOfTwoTeeth:
        case qc_motionOfMouth: MakeUnrelated(random, kind, motion); break;
        case qc_motionTwist:
            MakeRings(start);
            Twist(random, start, end);
            break;
        case qc_motionOfGrown:
            qcPatch_MakeGrown(random, 4 + qcRandom_Below(random, 20), 0.4, height, start);
            MoveInPlane(random, start, end);
            break;
        default:
            MakeStripOrTeeth(random, kind == qc_motionOfTeeth, 4 + qcRandom_Below(random, 12), height, start);
            MoveInPlane(random, start, end);
    }
    if (hasErrors)
        PlaceWithErrors(random, motion);
    else
        Place(random, 0.0, motion);
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
        MakeMotion(&random, (MotionKind)_i, &motion);
        char what[64];
        snprintf(what, sizeof what, "motion %d of kind %d", i, _i);
        CheckMotion(&motion, &counts, what);
    }
    printf("kind %d: %d motions, %d flat, %d meet themselves\n", _i, counts.all, counts.flat, counts.meet);
    ck_assert_int_gt(counts.flat, count / 25);
    ck_assert_int_gt(counts.meet, count / 100);
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
    TCase* tests = qcMakeCase("flat_patch_motion");
    tcase_add_loop_test(tests, a_patch_that_stays_flat_never_meets_itself, 0, qc_motionKindCount);
    tcase_add_test(tests, a_patch_that_turns_and_bends_a_little_is_flat);
    return qcRunCase("flat_patch_motion", tests);
}
