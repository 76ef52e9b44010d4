// Closest points, normal and signed distance of each pair in regions without a separating plane.
#include "manifold/pair_proximity.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <string.h>

enum
{
    // 256 pairs take about 0.2 ms.
    qc_minPairs = 256
};

typedef struct Job
{
    const qcContactTopology* topology;
    const qcContactRegions* regions;
    qcContactProximity* proximity;
} Job;

static void ComputeProximity(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    const qcManifoldPair* pair = qcContactTopology_Pair(job->topology, qcContactRegions_UnsettledPair(job->regions, i));
    double corners[2][3][3];
    for (int side = 0; side < 2; side++)
        memcpy(corners[side], pair->side[(side == 1) != pair->swapped]->corner, sizeof corners[side]);
    qcProximity_Of((const double(*)[3])corners[0], (const double(*)[3])corners[1], pair->relation,
                   &QC_AT(qcProximity, job->proximity->computed, pair->source),
                   &QC_AT(qcClosestFeatures, job->proximity->computedFeatures, pair->source));
}

static qcVector UnitOrUp(const double normal[3])
{
    qcVector n = qcVector_Load(normal);
    double length2 = qcDot(n, n);
    return length2 > 0.5 && length2 < 2.0 ? n : (qcVector){0.0, 0.0, 1.0};
}

static void SetPair(const qcManifoldPair* pair, const qcProximity* reported, qcPairProximity* proximity)
{
    qcVector normal = UnitOrUp(reported->normal);
    *proximity = (qcPairProximity){.normal = pair->swapped ? qcNegated(normal) : normal,
                                   .gap = reported->distance - reported->depth,
                                   .penetrating = pair->relation == qc_relationPenetrating && reported->depth > 0.0};
    qcSeparation separation = qcManifoldPair_Separation(pair, pair->side[1]->corner[0], proximity->normal);
    proximity->separated = !pair->intersecting && separation.along < -qcManifoldPair_Rounding(pair);
}

static qcStatus SetPairs(const qcContactTopology* topology, const qcContactRegions* regions,
                         qcContactProximity* proximity)
{
    QC_TRY(qcArray_Resize(&proximity->pairs, topology->pairs.count, sizeof(qcPairProximity), "proximities"));
    QC_TRY(qcArray_Resize(&proximity->regions, topology->regionCount, sizeof(qcRegionProximity), "proximities"));
    for (uint32_t r = 0; r < topology->regionCount; r++)
        QC_AT(qcRegionProximity, proximity->regions, r) = (qcRegionProximity){false, false};
    for (size_t i = 0; i < regions->unsettledPairs.count; i++)
    {
        uint32_t p = qcContactRegions_UnsettledPair(regions, i);
        const qcManifoldPair* pair = qcContactTopology_Pair(topology, p);
        qcPairProximity* own = &QC_AT(qcPairProximity, proximity->pairs, p);
        SetPair(pair, &proximity->reported[pair->source], own);
        qcRegionProximity* region = &QC_AT(qcRegionProximity, proximity->regions, pair->region);
        region->penetrating = region->penetrating || own->penetrating;
        region->ambiguous = region->ambiguous || !own->separated;
    }
    return qc_statusOk;
}

qcStatus qcContactProximity_Find(const qcManifoldInput* input, const qcContactTopology* topology,
                                 const qcContactRegions* regions, uint32_t threads, qcContactProximity* proximity)
{
    size_t unsettled = regions->unsettledPairs.count;
    proximity->reported = input->proximities;
    proximity->features = input->features;
    if ((input->proximities == NULL || topology->exponent != 0) && unsettled != 0)
    {
        size_t count = topology->pairs.count;
        QC_TRY(qcArray_Resize(&proximity->computed, count, sizeof(qcProximity), "proximities"));
        QC_TRY(qcArray_Resize(&proximity->computedFeatures, count, sizeof(qcClosestFeatures), "proximities"));
        Job job = {topology, regions, proximity};
        qcParallel_For(threads, unsettled, qc_minPairs, ComputeProximity, &job);
        proximity->reported = proximity->computed.data;
        proximity->features = proximity->computedFeatures.data;
    }
    return SetPairs(topology, regions, proximity);
}

void qcContactProximity_Free(qcContactProximity* proximity)
{
    qcArray* arrays[] = {&proximity->pairs, &proximity->regions, &proximity->computed, &proximity->computedFeatures};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
