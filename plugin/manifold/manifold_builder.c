// From the pairs of two bodies to their manifolds, stage by stage.
#include "manifold/manifold_builder.h"
#include "manifold/stage_switches.h"
#include "base/status.h"

#include <math.h>

static void Store(qcVector v, int exponent, double out[3])
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
    for (int axis = 0; axis < 3 && exponent != 0; axis++)
        out[axis] = ldexp(out[axis], exponent);
}

/// Converts a raw point to the scene's unit of length.
static qcManifoldPoint PointOf(const qcContactTopology* topology, const qcRawPoint* raw)
{
    const qcManifoldPair* pair = qcContactTopology_Pair(topology, raw->pair);
    int exponent = topology->exponent;
    qcManifoldPoint point = {.distance = exponent != 0 ? ldexp(raw->distance, exponent) : raw->distance,
                             .triangleA = pair->side[0]->index,
                             .triangleB = pair->side[1]->index,
                             .featureA = {raw->feature[0][0], raw->feature[0][1]},
                             .featureB = {raw->feature[1][0], raw->feature[1][1]}};
    Store(raw->end[0], exponent, point.pointA);
    Store(raw->end[1], exponent, point.pointB);
    Store(raw->normal, 0, point.normal);
    return point;
}

/// Appends the manifolds. Every region has a point: its first pair is covered by one, and the reduction keeps at least
/// one.
static qcStatus WriteResult(qcManifoldBuilder* b)
{
    const qcManifoldPair* any = qcContactTopology_Pair(&b->topology, 0);
    uint32_t regions = b->topology.regionCount;
    size_t firstManifold = b->manifolds.count, firstPoint = b->manifoldPoints.count, count = b->points.order.count;
    QC_TRY(qcArray_Reserve(&b->manifoldPoints, firstPoint + count, sizeof(qcManifoldPoint), "manifolds"));
    QC_TRY(qcArray_Resize(&b->manifolds, firstManifold + regions, sizeof(qcManifold), "manifolds"));
    b->manifoldPoints.count = firstPoint + count;
    qcManifold* manifolds = &QC_AT(qcManifold, b->manifolds, firstManifold);
    qcManifoldPoint* points = &QC_AT(qcManifoldPoint, b->manifoldPoints, firstPoint);
    for (uint32_t r = 0; r < regions; r++)
        manifolds[r] = (qcManifold){.bodyA = any->side[0]->slot, .bodyB = any->side[1]->slot};
    for (uint32_t i = 0; i < count; i++)
    {
        qcSortItem item = QC_AT(qcSortItem, b->points.order, i);
        qcManifold* manifold = &manifolds[item.key];
        if (manifold->pointCount++ == 0)
            manifold->firstPoint = i;
        points[i] = PointOf(&b->topology, qcContactPoints_Raw(&b->points, item.value));
    }
    return qc_statusOk;
}

qcStatus qcManifoldBuilder_Build(qcManifoldBuilder* b, const qcStepTriangles* triangles, const qcBodyPairInput* all,
                                 uint32_t threads)
{
    const qcContactTopology* topology = &b->topology;
    qcManifoldInput reported;
    qcBodyPairInput pairs;
    QC_TRY(qcSparsePairs_Choose(triangles, all, b->kernels, &b->sparse, &reported, &pairs));
    QC_TRY(qcContactTopology_Gather(triangles, &pairs, &b->topology));
    if (topology->pairs.count == 0)
        return qc_statusOk;
    QC_TRY(qcContactTopology_JoinRegions(&b->topology));
    double margin = pairs.reported->margin;
    if (topology->exponent != 0)
        margin = ldexp(margin, -topology->exponent);
    QC_TRY(qcContactRegions_Find(topology, b->kernels, margin, &b->regions));
    QC_TRY(qcContactProximity_Find(pairs.reported, topology, &b->regions, threads, &b->proximity));
    QC_TRY(qcPairAdjacency_Find(topology, &b->regions, &b->proximity, threads, &b->adjacency));
    const qcContactInput input = {.bodies = triangles->bodies,
                                  .topology = topology,
                                  .regions = &b->regions,
                                  .proximity = &b->proximity,
                                  .adjacency = &b->adjacency,
                                  .kernels = b->kernels,
                                  .margin = margin,
                                  .threads = threads};
    QC_TRY(qcPairOverlaps_Begin(threads, &b->overlaps));
    QC_TRY(qcContactNormals_Find(&input, &b->overlaps, &b->normals));
    QC_TRY(qcContactPoints_Collect(&input, &b->normals, &b->overlaps, &b->points));
    QC_TRY(qcContactPoints_Merge(topology, &b->points));
    if (QC_STAGE_RUNS(coplanarReduction))
        qcContactPoints_Reduce(topology, &b->normals, &b->points);
    QC_TRY(qcContactPoints_Order(topology, &b->points));
    return WriteResult(b);
}

void qcManifoldBuilder_Free(qcManifoldBuilder* b)
{
    qcSparsePairs_Free(&b->sparse);
    qcContactTopology_Free(&b->topology);
    qcContactRegions_Free(&b->regions);
    qcContactProximity_Free(&b->proximity);
    qcPairAdjacency_Free(&b->adjacency);
    qcPairOverlaps_Free(&b->overlaps);
    qcContactNormals_Free(&b->normals);
    qcContactPoints_Free(&b->points);
    qcArray_Free(&b->manifolds);
    qcArray_Free(&b->manifoldPoints);
}
