// Outward normals: where two closed bodies are deep in each other, a pair has no shortest way out of its own, since the
// surfaces around it have passed it. But the outer sides of all triangles of its region have a mean direction, the way
// out. Pairs whose normals don't lead out take an outward normal that lies along it. Limits: plugin/docs/manifolds.md.
#include "manifold/normals.h"
#include "base/status.h"
#include "scene/closed_surface.h"

#include <math.h>

// A way out is clear if the outward normals of each body's triangles lie along it by this on average. Those of a thin
// plate that is pierced cancel each other.
static const double s_clear = 0.3;
// A normal leads out if the cosines of its angles to the outward normals of the pair sum up to this.
static const double s_leadsOut = 0.5;

/// The direction in which side 0 leaves side 1 in a region.
typedef struct WayOut
{
    qcVector normal;  ///< unit; 0: none is clear
    qcVector sums[2]; ///< of outward normals, by side
    uint32_t count;   ///< of pairs
} WayOut;

typedef struct Job
{
    const qcContactInput* input;
    WayOut* ways;      ///< by region
    int outerSides[2]; ///< of both bodies: see qcBody_FindOuterSide
} Job;

static size_t CountPairs(const Job* job)
{
    return job->input->regions->unsettledPairs.count;
}

static const qcManifoldPair* PairAt(const Job* job, size_t i)
{
    return qcContactTopology_Pair(job->input->topology, qcContactRegions_UnsettledPair(job->input->regions, i));
}

static bool IsPenetrating(const qcContactInput* input, size_t region)
{
    return QC_AT(qcRegionProximity, input->proximity->regions, region).penetrating;
}

/// False: they have none, or nothing penetrates.
static bool FindOuterSides(Job* job)
{
    const qcContactInput* input = job->input;
    const qcManifoldPair* any = qcContactTopology_Pair(input->topology, 0);
    bool penetrates = false;
    for (uint32_t r = 0; r < input->topology->regionCount; r++)
        penetrates = penetrates || IsPenetrating(input, r);
    // A body that has been turned inside out in itself is led further in by its outer side.
    if (!penetrates || any->side[0]->slot == any->side[1]->slot)
        return false;
    for (int side = 0; side < 2; side++)
        job->outerSides[side] = qcBody_FindOuterSide(&QC_AT(qcBody, input->bodies->slots, any->side[side]->slot));
    return job->outerSides[0] != 0 && job->outerSides[1] != 0;
}

/// The direction in which side 0 leaves a triangle of the pair: out of that of side 1, or back out of its own.
static qcVector OutwardOf(const Job* job, const qcManifoldPair* pair, int side)
{
    qcVector normal = pair->side[side]->normal;
    return (job->outerSides[side] > 0) == (side == 1) ? normal : qcNegated(normal);
}

static void SetNormal(WayOut* way)
{
    const qcVector sum = qcPlusScaled(way->sums[0], way->sums[1], 1.0), zero = {0.0, 0.0, 0.0};
    double length = sqrt(qcDot(sum, sum)), minAlong = s_clear * way->count;
    if (!(length > 0.0))
        return;
    qcVector normal = qcPlusScaled(zero, sum, 1.0 / length);
    if (qcDot(way->sums[0], normal) > minAlong && qcDot(way->sums[1], normal) > minAlong)
        way->normal = normal;
}

static bool IsClear(const WayOut* way)
{
    return qcDot(way->normal, way->normal) > 0.0;
}

/// Finds the ways out of all regions. False: none is clear.
static bool FindWaysOut(const Job* job)
{
    size_t regions = job->input->topology->regionCount;
    bool any = false;
    for (size_t r = 0; r < regions; r++)
        job->ways[r] = (WayOut){.count = 0};
    for (size_t i = 0; i < CountPairs(job); i++)
    {
        const qcManifoldPair* pair = PairAt(job, i);
        WayOut* way = &job->ways[pair->region];
        way->count++;
        for (int side = 0; side < 2; side++)
            way->sums[side] = qcPlusScaled(way->sums[side], OutwardOf(job, pair, side), 1.0);
    }
    for (size_t r = 0; r < regions; r++)
    {
        if (IsPenetrating(job->input, r))
            SetNormal(&job->ways[r]);
        any = any || IsClear(&job->ways[r]);
    }
    return any;
}

/// The normal of a pair, or the outward one of its two along which it separates sooner.
static qcVector FindOutward(const Job* job, const qcManifoldPair* pair, qcVector own)
{
    const qcVector outward[2] = {OutwardOf(job, pair, 0), OutwardOf(job, pair, 1)};
    if (qcDot(own, outward[0]) + qcDot(own, outward[1]) >= s_leadsOut)
        return own;
    qcVector best = own, way = job->ways[pair->region].normal;
    double shortest = qcManifoldPair_LengthAlong(pair, own);
    for (int side = 0; side < 2; side++)
    {
        double length = qcManifoldPair_LengthAlong(pair, outward[side]);
        if (length < shortest && qcDot(outward[side], way) > 0.0)
        {
            best = outward[side];
            shortest = length;
        }
    }
    return best;
}

qcStatus qcContactNormals_LeadOut(const qcContactInput* input, qcPairOverlaps* overlaps, qcContactNormals* normals)
{
    Job job = {.input = input};
    if (!FindOuterSides(&job))
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&normals->waysOut, input->topology->regionCount, sizeof(WayOut), "normals of manifolds"));
    job.ways = normals->waysOut.data;
    if (!FindWaysOut(&job))
        return qc_statusOk;
    for (size_t i = 0; i < CountPairs(&job); i++)
    {
        const qcManifoldPair* pair = PairAt(&job, i);
        if (!IsClear(&job.ways[pair->region]))
            continue;
        uint32_t p = qcContactRegions_UnsettledPair(input->regions, i);
        qcVector own = qcContactNormals_Pair(normals, p)->normal, outward = FindOutward(&job, pair, own);
        if (qcDot(outward, own) < 1.0)
            QC_TRY(qcContactNormals_Set(input, p, outward, overlaps, normals));
    }
    return qc_statusOk;
}
