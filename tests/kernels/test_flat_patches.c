// A patch that the kernels of every instruction set prove flat has no self-contact within the query distance, by
// rational arithmetic; and patches that bend little are proven flat.
#include "support/oracle.h"
#include "kernels/patches.h"
#include "support/suite.h"

#include <stdio.h>

static bool IsFlat(const qcTriangleKernels* k, const qcPatch* patch, float query)
{
    qcPatchGeometry geometry = {.corners = patch->corners,
                                .points = patch->points,
                                .slots = patch->slots,
                                .loop = patch->loop,
                                .slotCount = patch->triangleCount,
                                .loopCount = patch->loopCount,
                                .pointError = patch->pointError,
                                .query = query};
    return k->isPatchFlat(&geometry);
}

//  ---- least distance of a patch from itself -------------------------------------------------------

/// A vertex, an edge or a triangle: a corner may be repeated.
typedef struct Feature
{
    uint32_t vertex[3];
    double corners[3][3], low[3], high[3];
} Feature;

enum
{
    qc_maxFeatures = qc_patchVertices + 4 * qc_patchTriangles
};

static void AddFeature(const qcPatch* patch, uint32_t a, uint32_t b, uint32_t c, Feature* features, size_t* count)
{
    Feature* f = &features[(*count)++];
    *f = (Feature){.vertex = {a, b, c}};
    for (int k = 0; k < 3; k++)
        memcpy(f->corners[k], patch->positions[f->vertex[k]], sizeof f->corners[k]);
    for (int i = 0; i < 3; i++)
    {
        f->low[i] = fmin(f->corners[0][i], fmin(f->corners[1][i], f->corners[2][i]));
        f->high[i] = fmax(f->corners[0][i], fmax(f->corners[1][i], f->corners[2][i]));
    }
}

static int CompareLowEnds(const void* f, const void* g)
{
    double a = ((const Feature*)f)->low[0], b = ((const Feature*)g)->low[0];
    return (a > b) - (a < b);
}

/// Ordered by lower ends. Inner edges occur twice.
static size_t ListFeatures(const qcPatch* patch, Feature* features)
{
    size_t count = 0;
    for (uint32_t v = 0; v < patch->vertexCount; v++)
        AddFeature(patch, v, v, v, features, &count);
    for (uint32_t t = 0; t < patch->triangleCount; t++)
    {
        const uint32_t* v = patch->corners[t].vertex;
        for (int c = 0; c < 3; c++)
            AddFeature(patch, v[c], v[(c + 1) % 3], v[(c + 1) % 3], features, &count);
        AddFeature(patch, v[0], v[1], v[2], features, &count);
    }
    qsort(features, count, sizeof features[0], CompareLowEnds);
    return count;
}

static bool ShareVertex(const Feature* f, const Feature* g)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            if (f->vertex[i] == g->vertex[k])
                return true;
    return false;
}

static bool AreBoxesWithin(const Feature* f, const Feature* g, double query)
{
    for (int i = 0; i < 3; i++)
        if (f->low[i] > g->high[i] + query || g->low[i] > f->high[i] + query)
            return false;
    return true;
}

/// True if projections on a direction prove the features farther apart than the distance. Coordinates are up to 1.
static bool Separates(const double w[3], const Feature* f, const Feature* g, double query)
{
    double length = sqrt(qcDot(w, w)), low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (int c = 0; c < 3; c++)
    {
        double at[2] = {qcDot(w, f->corners[c]), qcDot(w, g->corners[c])};
        for (int k = 0; k < 2; k++)
        {
            low[k] = fmin(low[k], at[k]);
            high[k] = fmax(high[k], at[k]);
        }
    }
    return fmax(low[0] - high[1], low[1] - high[0]) > (query + 1e-14) * length;
}

/// True if normals and edges of both, or directions across edges, prove the features farther apart: few pairs remain
/// for the oracle.
static bool AreProvenFarther(const Feature* f, const Feature* g, double query)
{
    const Feature* both[2] = {f, g};
    double edges[2][3][3], w[3], n[3];
    for (int s = 0; s < 2; s++)
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < 3; i++)
                edges[s][c][i] = both[s]->corners[(c + 1) % 3][i] - both[s]->corners[c][i];
    for (int c = 0; c < 3; c++)
        for (int d = 0; d < 3; d++)
        {
            for (int i = 0; i < 3; i++)
                w[i] = f->corners[c][i] - g->corners[d][i];
            if (Separates(w, f, g, query))
                return true;
            qcCross(edges[0][c], edges[1][d], n);
            if (Separates(n, f, g, query))
                return true;
            // Across the edge of one, from a corner of the other.
            for (int s = 0; s < 2; s++)
            {
                const double* e = edges[s][s == 0 ? c : d];
                double along = qcDot(w, e) / qcDot(e, e), across[3];
                for (int i = 0; i < 3; i++)
                    across[i] = w[i] - along * e[i];
                if (Separates(across, f, g, query))
                    return true;
            }
        }
    for (int s = 0; s < 2; s++)
    {
        qcCross(edges[s][0], edges[s][1], n);
        if (Separates(n, f, g, query))
            return true;
    }
    return false;
}

/// The least distance of two features without a common vertex: too large by at most 1e-9 of itself, or 3e-14.
static double FindLeast(const qcPatch* patch)
{
    Feature features[qc_maxFeatures];
    size_t count = ListFeatures(patch, features);
    double least = INFINITY;
    // A first bound from the ends of edges: it spares the oracle most.
    for (uint32_t t = 0; t < patch->triangleCount; t++)
        for (int c = 0; c < 3; c++)
        {
            const double *p = patch->positions[patch->corners[t].vertex[c]],
                         *q = patch->positions[patch->corners[t].vertex[(c + 1) % 3]];
            double along[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
            least = fmin(least, sqrt(qcDot(along, along)) * (1.0 + 1e-12));
        }
    for (size_t i = 0; i < count && least > 0.0; i++)
        for (size_t k = i + 1; k < count && least > 0.0 && features[k].low[0] <= features[i].high[0] + least; k++)
        {
            const Feature *f = &features[i], *g = &features[k];
            // The features just tested are part of many others.
            double minDistance = least - fmax(1e-9 * least, 3e-14);
            if (!AreBoxesWithin(f, g, least) || ShareVertex(f, g) ||
                (minDistance > 0.0 && AreProvenFarther(f, g, minDistance)))
                continue;
            qcOracleDistance* distance =
                qcOracleDistance_Create((const double(*)[3])f->corners, (const double(*)[3])g->corners);
            least = fmin(least, qcOracleDistance_Get(distance));
            qcOracleDistance_Destroy(distance);
        }
    return least;
}

/// Counts of the first kernels: all patches, those without self-intersection, and those proven flat with distance 0,
/// and with half and nearly all of their least distance.
typedef struct Counts
{
    int all, disjoint, flat, flatHalf, flatNearly;
} Counts;

/// With any query distance, also one at the least distance.
static void CheckPatch(qcRandom* random, const qcPatch* patch, Counts* counts, const char* what)
{
    double least = FindLeast(patch);
    const float queries[] = {0.0f,
                             (float)(0.5 * least),
                             (float)(0.98 * least),
                             qcRoundUp(least),
                             (float)(least * (1.0 + ldexp(1.0, -(int)qcRandom_Below(random, 20)))),
                             ldexpf(1.0f, -(int)qcRandom_Below(random, 25))};
    bool flat[3] = {false};
    FOR_EACH_KERNELS(k)
    for (size_t i = 0; i < sizeof queries / sizeof queries[0]; i++)
    {
        bool isFlat = IsFlat(k, patch, queries[i]);
        CHECK_THAT(!isFlat || (double)queries[i] < least,
                   "%s: %s is called flat with a query distance of %a; its least distance is %a", k->name, what,
                   (double)queries[i], least);
        if (kernelIndex == 0 && i < 3)
            flat[i] = isFlat;
    }
    counts->all++;
    counts->disjoint += least > 0.0;
    counts->flat += flat[0];
    counts->flatHalf += flat[1];
    counts->flatNearly += flat[2];
}

//  ---- tests ---------------------------------------------------------------------------------------

START_TEST(part_of_a_ring_that_is_flat_has_no_self_contact)
{
    qcRandom random = {17};
    Counts counts = {0};
    for (int i = 0; i < 1200; i++)
    {
        // Ends coincide, almost touch or overlap; ramps that face one way everywhere; crumpled ones.
        double near = i % 3 == 0 ? 0.0 : ldexp(qcRandom_Uniform(&random, -1.0, 1.0), -(i / 4 % 28));
        double rounds = i % 2 == 0 ? 1.0 + near : qcRandom_Uniform(&random, 0.3, i % 8 < 4 ? 7.0 : 2.5);
        double rise = i % 4 == 0 || i % 8 == 3 ? 0.0 : i % 4 == 1 ? 0.05 : ldexp(1.0, -(i / 4 % 30));
        double noise = i % 5 == 0 ? ldexp(0.2, -(i / 5 % 30)) : i % 5 == 1 ? 0.03 : 0.0;
        qcPatch patch;
        qcPatch_MakeRing(&random, i % 3 == 1 ? 3 + (uint32_t)i / 3 % 8 : qc_patchColumns, rounds, rise, noise, &patch);
        char what[128];
        snprintf(what, sizeof what, "patch %d of %a rounds, rise %a, noise %a", i, rounds, rise, noise);
        CheckPatch(&random, &patch, &counts, what);
    }
    ck_assert_int_gt(counts.all - counts.disjoint, 50);
    ck_assert_int_gt(counts.disjoint, 50);
    ck_assert_int_gt(counts.flat, counts.disjoint / 8);
}
END_TEST

/// Most of the unit box or a small part of it; points with errors or without.
static void PlaceAny(qcRandom* random, int i, qcPatch* patch)
{
    double size = i % 4 == 3 ? ldexp(1.0, -1 - i / 4 % 14) : 0.9;
    double error = i % 3 == 2 ? size * ldexp(1.0, -5 - i / 3 % 18) : 0.0;
    qcPatch_Place(patch, random, i % 2 == 0, size, error < 0x1p-24 ? 0.0 : error);
}

/// Enough patches were proven flat, also with a query distance, for the test to mean something.
static void CheckCounts(const Counts* counts, int count)
{
    ck_assert_int_gt(counts->flat, count / 4);
    ck_assert_int_gt(counts->flatHalf, count / 8);
    ck_assert_int_gt(counts->flatNearly, count / 50);
}

START_TEST(a_strip_that_is_flat_has_no_self_contact)
{
    qcRandom random = {31};
    Counts counts = {0};
    int count = qcGetTestPairCount(1000);
    for (int i = 0; i < count; i++)
    {
        qcPatch patch;
        qcStripKind kind = (qcStripKind)(i / 2 % qc_stripKindCount);
        double notch = i % 3 == 0 ? 0.0 : qcRandom_Uniform(&random, 0.0, i % 3 == 1 ? 0.3 : 0.95);
        double noise = i / 3 % 3 == 0 ? 0.0 : qcRandom_Uniform(&random, 0.0, i / 3 % 3 == 1 ? 0.1 : 0.4);
        double height = i % 5 < 2 ? 0.0 : qcRandom_Uniform(&random, 0.0, 1.0);
        qcPatch_MakePath(&random, kind, 2 + qcRandom_Below(&random, qc_patchColumns - 1), notch, noise, height, &patch);
        PlaceAny(&random, i, &patch);
        char what[128];
        snprintf(what, sizeof what, "strip %d, way %d, notch %g, noise %g", i, (int)kind, notch, noise);
        CheckPatch(&random, &patch, &counts, what);
    }
    CheckCounts(&counts, count);
}
END_TEST

START_TEST(a_grown_patch_that_is_flat_has_no_self_contact)
{
    qcRandom random = {32};
    Counts counts = {0};
    int count = qcGetTestPairCount(4000);
    for (int i = 0; i < count; i++)
    {
        qcPatch patch;
        uint32_t triangles = 1 + qcRandom_Below(&random, i % 4 == 0 ? 30 : 9);
        double fan = i % 3 == 0 ? 0.8 : 0.2, height = i % 5 < 3 ? 0.0 : ldexp(1.0, -i % 10);
        qcPatch_MakeGrown(&random, triangles, fan, height, &patch);
        PlaceAny(&random, i, &patch);
        char what[128];
        snprintf(what, sizeof what, "grown patch %d of %u triangles", i, patch.triangleCount);
        CheckPatch(&random, &patch, &counts, what);
    }
    CheckCounts(&counts, count);
}
END_TEST

START_TEST(a_fan_that_is_flat_has_no_self_contact)
{
    qcRandom random = {34};
    Counts counts = {0};
    int count = qcGetTestPairCount(1500);
    for (int i = 0; i < count; i++)
    {
        qcPatch patch;
        double height = i % 5 < 3 ? 0.0 : ldexp(1.0, -i % 8), open = ldexp(qcRandom_Uniform(&random, 0.5, 2.0), -i % 9);
        qcPatch_MakeFan(&random, 3 + qcRandom_Below(&random, 12), open, height, &patch);
        PlaceAny(&random, i, &patch);
        char what[128];
        snprintf(what, sizeof what, "fan %d of %u triangles, %g open", i, patch.triangleCount, open);
        CheckPatch(&random, &patch, &counts, what);
    }
    CheckCounts(&counts, count);
}
END_TEST

START_TEST(a_row_of_teeth_that_is_flat_has_no_self_contact)
{
    qcRandom random = {35};
    Counts counts = {0};
    int count = qcGetTestPairCount(800);
    for (int i = 0; i < count; i++)
    {
        qcPatch patch;
        double height = i % 5 < 3 ? 0.0 : ldexp(1.0, -i % 8), lean = 0.5 + ldexp(i % 2 == 0 ? 0.1 : -0.3, -i % 7);
        qcPatch_MakeTeeth(&random, 2 + qcRandom_Below(&random, 12), lean, height, &patch);
        PlaceAny(&random, i, &patch);
        char what[128];
        snprintf(what, sizeof what, "row %d of %u triangles, lean %g", i, patch.triangleCount, lean);
        CheckPatch(&random, &patch, &counts, what);
    }
    CheckCounts(&counts, count);
}
END_TEST

START_TEST(a_patch_that_bends_little_is_flat_and_one_that_folds_is_not)
{
    qcRandom random = {18};
    for (int i = 0; i < 40; i++)
    {
        qcPatch patch;
        qcPatch_MakeRing(&random, qc_patchColumns, 0.6, 0.05, 0.001, &patch);
        FOR_EACH_KERNELS(k)
        ck_assert(IsFlat(k, &patch, 0.0f));
        // One vertex beyond the opposite edge; or all at one point.
        uint32_t v = qcPatch_Vertex(5 + (uint32_t)i % 10, 0);
        patch.points[v] = patch.points[qcPatch_Vertex(3 + (uint32_t)i % 10, 1)];
        FOR_EACH_KERNELS(k)
        ck_assert(!IsFlat(k, &patch, 0.0f));
        for (int k = 0; k < qc_patchVertices; k++)
            patch.points[k] = patch.points[0];
        FOR_EACH_KERNELS(k)
        ck_assert(!IsFlat(k, &patch, 0.0f));
    }
}
END_TEST

START_TEST(a_patch_that_bends_little_is_flat_within_a_quarter_of_an_edge)
{
    qcRandom random = {33};
    for (int i = 0; i < 400; i++)
    {
        // Squares in the plane, then waves; their edges are about 1 before they are placed.
        qcPatch patch;
        qcPatch_MakeStrip(&patch, qc_patchColumns);
        for (uint32_t c = 0; c <= qc_patchColumns; c++)
            for (uint32_t r = 0; r <= qc_patchRows; r++)
            {
                double* x = patch.positions[qcPatch_Vertex(c, r)];
                x[0] = c + qcRandom_Uniform(&random, -0.1, 0.1);
                x[1] = r + 0.5 * (i % 2 == 0 ? 0.0 : sin(0.5 * c)) + qcRandom_Uniform(&random, -0.1, 0.1);
                x[2] = 0.3 * sin(0.4 * c + 0.5 * r + i);
            }
        double size = i % 3 == 0 ? 0.9 : ldexp(1.0, -i % 6);
        qcPatch_Place(&patch, &random, i % 4 == 0, size, 0.0);
        double* ends[2] = {patch.positions[qcPatch_Vertex(0, 1)], patch.positions[qcPatch_Vertex(qc_patchColumns, 1)]};
        double across[3] = {ends[1][0] - ends[0][0], ends[1][1] - ends[0][1], ends[1][2] - ends[0][2]};
        float query = (float)(0.25 * sqrt(qcDot(across, across)) / qc_patchColumns);
        FOR_EACH_KERNELS(k)
        CHECK_THAT(IsFlat(k, &patch, query), "%s: patch %d is not flat", k->name, i);
    }
}
END_TEST

QC_RUN_TESTS("flat_patches", part_of_a_ring_that_is_flat_has_no_self_contact, a_strip_that_is_flat_has_no_self_contact,
             a_grown_patch_that_is_flat_has_no_self_contact, a_fan_that_is_flat_has_no_self_contact,
             a_row_of_teeth_that_is_flat_has_no_self_contact,
             a_patch_that_bends_little_is_flat_and_one_that_folds_is_not,
             a_patch_that_bends_little_is_flat_within_a_quarter_of_an_edge)
