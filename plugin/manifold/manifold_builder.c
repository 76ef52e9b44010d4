// Of two bodies, or of one with itself: from pairs of triangles to contact points, step by step; each step is a file of
// its own.
#include "manifold/manifold_builder.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <math.h>

// Points nearer than this share of the triangles' size are one: in a region, the longest edge of a pair's smaller
// triangle, on average.
static const double s_tolerance = 1.0 / 64.0;

/// What points ask of the regions that they belong to.
static qcStatus MeasureRegions(qcManifoldBuilder* m)
{
    QC_TRY(qcArray_Resize(&m->measured, m->regions.count, sizeof(qcContactRegion), "regions of contact"));
    for (uint32_t r = 0; r < m->measured.count; r++)
        QC_AT(qcContactRegion, m->measured, r) = (qcContactRegion){0};
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        qcContactRegion* region = &QC_AT(qcContactRegion, m->measured, pair->region);
        region->tolerance += s_tolerance * qcManifoldPair_SmallerSize(pair);
        region->crossing = region->crossing || pair->crossing;
        region->pairs++;
    }
    for (uint32_t r = 0; r < m->measured.count; r++)
        QC_AT(qcContactRegion, m->measured, r).tolerance /= QC_AT(qcContactRegion, m->measured, r).pairs;
    return qc_statusOk;
}

static void Store(qcVector v, int exponent, double out[3])
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
    for (int axis = 0; axis < 3 && exponent != 0; axis++)
        out[axis] = ldexp(out[axis], exponent);
}

static qcManifoldPoint PointOf(const qcManifoldBuilder* m, const qcRawPoint* raw)
{
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, raw->pair);
    qcManifoldPoint point = {.distance = m->exponent != 0 ? ldexp(raw->distance, m->exponent) : raw->distance,
                             .triangleA = pair->side[0]->index,
                             .triangleB = pair->side[1]->index,
                             .featureA = {raw->feature[0][0], raw->feature[0][1]},
                             .featureB = {raw->feature[1][0], raw->feature[1][1]}};
    Store(raw->end[0], m->exponent, point.pointA);
    Store(raw->end[1], m->exponent, point.pointB);
    Store(raw->normal, 0, point.normal);
    return point;
}

/// Every region has a point: its first pair is covered by one, and at least one point of a region stays.
static qcStatus WriteResult(qcManifoldBuilder* m)
{
    const qcManifoldPair* any = qcManifoldBuilder_Pair(m, 0);
    size_t firstManifold = m->manifolds.count, firstPoint = m->points.count, count = m->order.count;
    QC_TRY(qcArray_Reserve(&m->points, firstPoint + count, sizeof(qcManifoldPoint), "manifolds"));
    QC_TRY(qcArray_Resize(&m->manifolds, firstManifold + m->regions.count, sizeof(qcManifold), "manifolds"));
    m->points.count = firstPoint + count;
    qcManifold* manifolds = &QC_AT(qcManifold, m->manifolds, firstManifold);
    qcManifoldPoint* points = &QC_AT(qcManifoldPoint, m->points, firstPoint);
    for (size_t r = 0; r < m->regions.count; r++)
        manifolds[r] = (qcManifold){.bodyA = any->side[0]->slot, .bodyB = any->side[1]->slot};
    for (uint32_t i = 0; i < count; i++)
    {
        qcSortItem item = QC_AT(qcSortItem, m->order, i);
        qcManifold* manifold = &manifolds[item.key];
        if (manifold->pointCount++ == 0)
            manifold->firstPoint = i;
        points[i] = PointOf(m, &QC_AT(qcRawPoint, m->raw, item.value));
    }
    return qc_statusOk;
}

static qcStatus EmptyWorkers(qcManifoldBuilder* m, uint32_t threads)
{
    QC_TRY(qcWorkerResults_Begin(&m->workers, threads, sizeof(qcManifoldWorker), "contact points"));
    for (size_t i = 0; i < m->workers.count; i++)
    {
        qcManifoldWorker* worker = &QC_AT(qcManifoldWorker, m->workers, i);
        worker->rings.count = worker->points.count = 0;
    }
    return qc_statusOk;
}

qcStatus qcManifoldBuilder_LoopStatus(const qcManifoldBuilder* m)
{
    return qcWorkerResults_End(&m->workers, sizeof(qcManifoldWorker));
}

/// Without a pair there is nothing in the result.
qcStatus qcManifoldBuilder_Build(qcManifoldBuilder* m, const qcStepTriangles* triangles, const qcMeetingInput* input,
                                 uint32_t threads)
{
    QC_TRY(EmptyWorkers(m, threads));
    qcMeetingInput known = *input;
    QC_TRY(qcManifoldBuilder_TakePairs(m, triangles, &known));
    if (m->work.count == 0)
        return qc_statusOk;
    QC_TRY(qcManifoldBuilder_JoinRegions(m));
    QC_TRY(qcManifoldBuilder_FindPlanes(m, known.margin));
    QC_TRY(qcManifoldBuilder_AskPairs(m, &known, threads));
    QC_TRY(qcManifoldBuilder_FindRings(m, threads));
    QC_TRY(qcManifoldBuilder_ChooseNormals(m, &known, threads));
    QC_TRY(qcManifoldBuilder_ChooseSigns(m, &known));
    QC_TRY(qcManifoldBuilder_FindEscapes(m, known.margin));
    QC_TRY(MeasureRegions(m));
    QC_TRY(qcManifoldBuilder_FindPoints(m, &known, threads));
    QC_TRY(qcManifoldBuilder_MergePoints(m));
    qcManifoldBuilder_DropBetween(m);
    QC_TRY(qcManifoldBuilder_OrderKept(m));
    return WriteResult(m);
}

static void FreeWorkers(qcManifoldBuilder* m)
{
    for (size_t i = 0; i < m->workers.count; i++)
    {
        qcManifoldWorker* worker = &QC_AT(qcManifoldWorker, m->workers, i);
        qcArray* arrays[] = {&worker->rings, &worker->points, &worker->views, &worker->listOf,
                             &worker->lists, &worker->fans,   &worker->seen};
        for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++)
            qcArray_Free(arrays[k]);
    }
    qcArray_Free(&m->workers);
}

void qcManifoldBuilder_Free(qcManifoldBuilder* m)
{
    FreeWorkers(m);
    qcArray* arrays[] = {&m->work,     &m->triangles, &m->numbers, &m->vertexNumbers, &m->vertices,    &m->table,
                         &m->last,     &m->freePairs, &m->pairsOf, &m->places,        &m->proximities, &m->feet,
                         &m->choices,  &m->heard,     &m->nodes,   &m->regions,       &m->planes,      &m->parts,
                         &m->measured, &m->corners,   &m->raw,     &m->firstRaw,      &m->witnessed,   &m->order,
                         &m->scratch,  &m->heads,     &m->links,   &m->keepers,       &m->members,     &m->manifolds,
                         &m->points};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
