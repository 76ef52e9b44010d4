// Pairs of one or two BVHs against rational arithmetic, all triangles with all others: no pair within the query
// distance is missing, none is found twice, and the class of each is right.
#ifndef QC_TESTS_SWEEP_BVH_PAIRS_MODEL_H
#define QC_TESTS_SWEEP_BVH_PAIRS_MODEL_H

#include "sweep/bvh/bvh_pairs.h"

#include "support/oracle.h"
#include "sweep/sample_bodies.h"

#include <math.h>

enum
{
    qc_maxThreads = 3
};

/// A soup, its body and the body's BVH.
typedef struct qcSide
{
    qcSoup soup;
    qcBodies bodies;
    qcBodyBvh bvh;
} qcSide;

static inline qcSide qcSide_Make(qcSoup soup)
{
    qcSide side = {.soup = soup};
    const qcBody* body = qcBodyAt(&side.bodies, qcAddToBodies(&side.bodies, &soup));
    CHECK_OK(qcBodyBvh_Build(&side.bvh, body, NULL, 1));
    CHECK_OK(qcBodyBvh_BuildAdjacency(&side.bvh, 1));
    return side;
}

static inline void qcSide_Free(qcSide* side)
{
    qcBodyBvh_Free(&side->bvh);
    qcBodies_Free(&side->bodies);
    qcSoup_Free(&side->soup);
}

static inline void qcSide_Fit(qcSide* side, double margin, const qcTriangleKernels* kernels, uint32_t threads)
{
    qcBvhScratch scratch = {0};
    bool fits;
    CHECK_OK(qcTriangleBvh_Fit(&side->bvh.bvh, qcBodyAt(&side->bodies, 0), margin, kernels, threads, &scratch, &fits));
    ck_assert(fits);
    qcBvhScratch_Free(&scratch);
}

/// The number of times that each pair of triangles was found, and its class: a row for each triangle of the first side.
typedef struct qcFoundPairs
{
    const qcSide *a, *b;
    uint8_t* times[qc_maxThreads]; ///< by worker
    uint8_t* classes;              ///< 0: undecided, or 1 + a relation
    bool half;                     ///< the near distance is half of the query distance
    size_t calls, count;
    const uint8_t *visitedA, *visitedB;
} qcFoundPairs;

static inline void qcFoundPairs_Make(qcFoundPairs* times, const qcSide* a, const qcSide* b)
{
    size_t cells = (size_t)a->soup.triangleCount * b->soup.triangleCount;
    *times = (qcFoundPairs){.a = a, .b = b, .classes = calloc(cells, 1)};
    ck_assert_ptr_nonnull(times->classes);
    for (int w = 0; w < qc_maxThreads; w++)
        ck_assert_ptr_nonnull(times->times[w] = calloc(cells, 1));
}

static inline void qcFoundPairs_Free(qcFoundPairs* times)
{
    for (int w = 0; w < qc_maxThreads; w++)
        free(times->times[w]);
    free(times->classes);
}

static inline bool qcFoundPairs_Add(void* context, const qcClassifiedPairs* found, uint32_t worker)
{
    qcFoundPairs* times = context;
    size_t classified = found->nearCount + found->separateCount + found->intersectingCount;
    CHECK_THAT(worker < qc_maxThreads && found->count != 0 && classified <= found->count,
               "worker %u, %zu pairs, %zu are classified", worker, found->count, classified);
    for (size_t i = 0; i < found->count; i++)
    {
        uint32_t t = QC_AT(uint32_t, times->a->bvh.bvh.clusters.triangles, found->pairs[i].a),
                 u = QC_AT(uint32_t, times->b->bvh.bvh.clusters.triangles, found->pairs[i].b);
        CHECK_THAT(t < times->a->soup.triangleCount && u < times->b->soup.triangleCount, "no such triangle");
        if (times->a == times->b && u < t)
        {
            uint32_t swapped = t;
            t = u;
            u = swapped;
        }
        size_t at = (size_t)t * times->b->soup.triangleCount + u;
        times->times[worker][at] = (uint8_t)(times->times[worker][at] + (times->times[worker][at] < 255));
        size_t disjoint = found->nearCount + found->separateCount;
        times->classes[at] = (uint8_t)(i < found->nearCount                      ? 1 + qc_relationNear
                                       : i < disjoint                            ? 1 + qc_relationDisjoint
                                       : i < disjoint + found->intersectingCount ? 1 + qc_relationPenetrating
                                                                                 : 0);
    }
    return true;
}

static inline bool qcStopSearch(void* context, const qcClassifiedPairs* found, uint32_t worker)
{
    (void)found;
    (void)worker;
    __atomic_fetch_add((size_t*)context, 1, __ATOMIC_RELAXED);
    return false;
}

/// A BVH with itself, for a function that stops the search; `calls` counts its calls.
static inline qcBvhPairsJob qcMakeSelfJob(const qcSide* side, size_t* calls)
{
    return (qcBvhPairsJob){.kernels = qcTriangleKernels_Get(),
                           .a = &side->bvh,
                           .b = &side->bvh,
                           .bodyA = qcBodyAt(&side->bodies, 0),
                           .bodyB = qcBodyAt(&side->bodies, 0),
                           .function = qcStopSearch,
                           .context = calls};
}

static inline bool qcAreBoxesWithin(const double a[3][3], const double b[3][3], double margin)
{
    for (int axis = 0; axis < 3; axis++)
    {
        double lowA = fmin(a[0][axis], fmin(a[1][axis], a[2][axis])),
               highA = fmax(a[0][axis], fmax(a[1][axis], a[2][axis]));
        double lowB = fmin(b[0][axis], fmin(b[1][axis], b[2][axis])),
               highB = fmax(b[0][axis], fmax(b[1][axis], b[2][axis]));
        // Rounding is monotone: boxes that this separates are separate.
        if (lowA > highB + margin || lowB > highA + margin)
            return false;
    }
    return true;
}

/// Results of rational arithmetic for each two triangles, computed when first needed.
typedef struct qcPairOracle
{
    const qcSide *a, *b;
    double margin;
    uint8_t* within;   ///< 0: unknown, 1: farther apart than the margin, 2: within it, 3: within half of it
    uint8_t* relation; ///< 0: unknown, or 1 + the relation without a margin
    size_t boxes;      ///< tested pairs whose boxes are within the margin
    size_t classes[qc_relationNear + 1]; ///< classified pairs by relation, of all kernels
} qcPairOracle;

static inline qcPairOracle qcPairOracle_Make(const qcSide* a, const qcSide* b, double margin)
{
    size_t cells = (size_t)a->soup.triangleCount * b->soup.triangleCount;
    qcPairOracle oracle = {a, b, margin, calloc(cells, 1), calloc(cells, 1), 0, {0}};
    ck_assert_ptr_nonnull(oracle.within);
    ck_assert_ptr_nonnull(oracle.relation);
    return oracle;
}

static inline void qcPairOracle_Free(qcPairOracle* oracle)
{
    free(oracle->within);
    free(oracle->relation);
}

static inline bool qcPairOracle_AreWithin(qcPairOracle* oracle, uint32_t t, uint32_t u)
{
    uint8_t* within = &oracle->within[(size_t)t * oracle->b->soup.triangleCount + u];
    if (*within != 0)
        return *within >= 2;
    double p[3][3], q[3][3];
    qcSoup_GetTriangle(&oracle->a->soup, t, p);
    qcSoup_GetTriangle(&oracle->b->soup, u, q);
    *within = 1;
    if (!qcAreBoxesWithin((const double(*)[3])p, (const double(*)[3])q, oracle->margin))
        return false;
    oracle->boxes++;
    qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])p, (const double(*)[3])q);
    *within = qcOracleDistance_Compare(distance, 0.5 * oracle->margin) <= 0 ? 3
              : qcOracleDistance_Compare(distance, oracle->margin) <= 0     ? 2
                                                                            : 1;
    qcOracleDistance_Destroy(distance);
    return *within >= 2;
}

static inline qcRelation qcPairOracle_Relate(qcPairOracle* oracle, uint32_t t, uint32_t u)
{
    uint8_t* relation = &oracle->relation[(size_t)t * oracle->b->soup.triangleCount + u];
    double p[3][3], q[3][3];
    if (*relation == 0)
    {
        qcSoup_GetTriangle(&oracle->a->soup, t, p);
        qcSoup_GetTriangle(&oracle->b->soup, u, q);
        *relation = (uint8_t)(1 + qcOracle_Relate((const double(*)[3])p, (const double(*)[3])q));
    }
    return (qcRelation)(*relation - 1);
}

/// Checks the class of two triangles. `half`: the near distance is half of the query distance.
static inline void qcPairOracle_CheckClass(qcPairOracle* oracle, uint32_t t, uint32_t u, bool half, qcRelation class,
                                           const char* what)
{
    qcRelation relation = qcPairOracle_Relate(oracle, t, u);
    bool isWithin = qcPairOracle_AreWithin(oracle, t, u) &&
                    (!half || oracle->within[(size_t)t * oracle->b->soup.triangleCount + u] == 3);
    if (relation == qc_relationDisjoint && isWithin)
        relation = qc_relationNear;
    CHECK_THAT(class == relation, "%s: %u and %u are classified %d, and are %d", what, t, u, (int)class, (int)relation);
    oracle->classes[class]++;
}

static inline void qcCheckVisited(const qcSide* side, const uint8_t* visited, uint32_t triangle)
{
    const qcArray* slots = &side->bvh.bvh.clusters.triangles;
    for (size_t i = 0; i < slots->count; i++)
        if (QC_AT(uint32_t, *slots, i) == triangle)
            CHECK_THAT(visited[i / qc_nodeSize] == 1, "node %zu was not visited", i / qc_nodeSize);
}

/// Checks the pairs of all workers against the oracle, and adds up their number.
static inline void qcFoundPairs_Check(qcFoundPairs* found, qcPairOracle* oracle, bool includeNeighbours,
                                      const char* what)
{
    size_t n = found->a->soup.triangleCount, m = found->b->soup.triangleCount;
    for (uint32_t t = 0; t < n; t++)
        for (uint32_t u = 0; u < m; u++)
        {
            size_t at = t * m + u;
            int times = found->times[0][at] + found->times[1][at] + found->times[2][at];
            bool self = found->a == found->b,
                 isExcluded = self && !includeNeighbours && qcSoup_AreNeighbours(&found->a->soup, t, u);
            CHECK_THAT(times <= 1, "%s: %u and %u are found %d times", what, t, u, times);
            CHECK_THAT(times == 0 || (!isExcluded && (!self || t < u)), "%s: %u and %u are found", what, t, u);
            // Only missing pairs are tested.
            CHECK_THAT(times == 1 || isExcluded || (self && t >= u) || !qcPairOracle_AreWithin(oracle, t, u),
                       "%s: %u and %u are not found", what, t, u);
            found->count += (size_t)times;
            if (found->classes[at] != 0)
                qcPairOracle_CheckClass(oracle, t, u, found->half, (qcRelation)(found->classes[at] - 1), what);
            if (times != 0 && at % 509 == 0)
            {
                qcCheckVisited(found->a, found->visitedA, t);
                qcCheckVisited(found->b, found->visitedB, u);
            }
        }
}

/// Takes the adjacency away, as if it were not built yet, or gives it back.
static inline void qcSide_SetAdjacency(qcSide* side, bool hasAdjacency)
{
    const qcTriangleBvh* bvh = &side->bvh.bvh;
    side->bvh.hasAdjacency = hasAdjacency;
    qcArray_Free(&side->bvh.vertices);
    if (!hasAdjacency)
        CHECK_OK(qcClusters_ListVertices(&bvh->clusters, bvh->corners.data, bvh->vertexCount, 1, &side->bvh.vertices));
}

/// Finds the pairs with all kernels, on one thread and, with half the near distance, on three; without flat patches,
/// with them, and without adjacency. Returns their number, with the last kernels.
static inline size_t qcCheckPairs(qcSide* a, qcSide* b, double margin, bool includeNeighbours, qcPairOracle* oracle,
                                  const char* what)
{
    size_t count = 0;
    bool flat = a == b && !includeNeighbours;
    FOR_EACH_KERNELS(k)
    for (int run = 0; run < (flat ? 6 : 2); run++)
    {
        uint32_t threads = run % 2 == 0 ? 1 : qc_maxThreads;
        qcSide_Fit(a, margin, k, threads);
        qcSide_Fit(b, margin, k, threads);
        qcFoundPairs found;
        qcFoundPairs_Make(&found, a, b);
        found.half = run % 2 == 1;
        uint8_t* visited[2] = {calloc(a->bvh.bvh.clusters.nodeCount, 1), calloc(b->bvh.bvh.clusters.nodeCount, 1)};
        found.visitedA = visited[0];
        found.visitedB = a == b ? visited[0] : visited[1];
        qcBvhPairs pairs = {0};
        uint64_t neighbours = 0;
        if (run == 4)
            qcSide_SetAdjacency(a, false);
        qcBvhPairsJob job = {.kernels = k,
                             .a = &a->bvh,
                             .b = &b->bvh,
                             .bodyA = qcBodyAt(&a->bodies, 0),
                             .bodyB = qcBodyAt(&b->bodies, 0),
                             .query = margin,
                             .near = found.half ? 0.5 * margin : margin,
                             .includeNeighbours = includeNeighbours,
                             .skipFlatPatches = run / 2 == 1,
                             .neighbourCount = &neighbours,
                             .visitedA = visited[0],
                             .visitedB = a == b ? visited[0] : visited[1],
                             .function = qcFoundPairs_Add,
                             .context = &found};
        if (job.skipFlatPatches)
            qcPatchState_Test(&a->bvh.patches, &a->bvh.bvh, k, threads);
        CHECK_OK(qcBvhPairs_Find(&pairs, &job, 1, threads));
        qcFoundPairs_Check(&found, oracle, includeNeighbours, what);
        CHECK_THAT(run % 2 == 0 || count == found.count, "%s: %zu pairs on one thread, %zu on three", what, count,
                   found.count);
        count = found.count;
        CHECK_THAT(neighbours == (run < 4 ? 0 : a->bvh.bvh.clusters.neighbourCount), "%s: %zu neighbours", what,
                   (size_t)neighbours);
        if (run == 5)
            qcSide_SetAdjacency(a, true);
        qcBvhPairs_Free(&pairs);
        qcFoundPairs_Free(&found);
        free(visited[0]);
        free(visited[1]);
        a->bvh.bvh.fit.fitted = b->bvh.bvh.fit.fitted = false; // for the next kernels
    }
    return count;
}

/// Returns the number of pairs.
static inline size_t qcCheckBetween(qcSoup soupA, qcSoup soupB, double margin, const char* what)
{
    qcSide a = qcSide_Make(soupA), b = qcSide_Make(soupB);
    qcPairOracle oracle = qcPairOracle_Make(&a, &b, margin);
    size_t count = qcCheckPairs(&a, &b, margin, false, &oracle, what);
    qcPairOracle_Free(&oracle);
    qcSide_Free(&a);
    qcSide_Free(&b);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    return count;
}

static inline void qcCheckWithin(qcSoup soup, double margin, const char* what)
{
    qcSide a = qcSide_Make(soup);
    qcPairOracle oracle = qcPairOracle_Make(&a, &a, margin);
    for (int includeNeighbours = 0; includeNeighbours <= 1; includeNeighbours++)
        qcCheckPairs(&a, &a, margin, includeNeighbours != 0, &oracle, what);
    qcPairOracle_Free(&oracle);
    qcSide_Free(&a);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

static const char* const qcSoupKindNames[] = {"one",  "node and one", "random", "degenerate", "sphere", "cloth",
                                              "flat", "line",         "point",  "fan",        "twins"};

/// Soups with few pairs within the margin, so that the oracle tests few.
static inline qcSoup qcMakeSmallSoup(qcSoupKind kind, uint64_t seed)
{
    qcSoup soup = qcMakeSoup(kind, seed);
    soup.triangleCount = kind == qc_soupFan && soup.triangleCount > 130 ? 130 : soup.triangleCount;
    return soup;
}

#endif
