// What the free pairs say themselves, those of regions that no plane parts. In parallel.
#include "manifold/manifold_builder.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <string.h>

enum
{
    // 256 pairs take about 0.2 ms.
    qc_leastPairs = 256
};

typedef struct Job
{
    const qcManifoldBuilder* manifolds;
    qcMeetingInput* input;
} Job;

static void ComputeProximity(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    const qcManifoldBuilder* m = job->manifolds;
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, qcManifoldBuilder_FreePair(m, i));
    double corners[2][3][3];
    for (int side = 0; side < 2; side++)
        memcpy(corners[side], pair->side[(side == 1) != pair->swapped]->corner, sizeof corners[side]);
    qcProximity_Of((const double(*)[3])corners[0], (const double(*)[3])corners[1], pair->relation,
                   &QC_AT(qcProximity, m->proximities, pair->source), &QC_AT(qcClosestFeatures, m->feet, pair->source));
}

static qcVector UnitOrUp(const double normal[3])
{
    qcVector n = qcVector_Load(normal);
    double length2 = qcDot(n, n);
    return length2 > 0.5 && length2 < 2.0 ? n : (qcVector){0.0, 0.0, 1.0};
}

/// Do the triangles lie beside a plane each, with some room between them?
static bool AreParted(const qcManifoldPair* pair)
{
    qcVector origin = pair->side[1]->corner[0];
    qcWaysOut ways = qcWaysOut_Of(qcManifoldTriangle_Heights(pair->side[0], origin, pair->normal),
                                  qcManifoldTriangle_Heights(pair->side[1], origin, pair->normal));
    return ways.along < -qcManifoldPair_Rounding(pair);
}

static void TakeProximity(qcManifoldBuilder* m, const qcMeetingInput* input, uint32_t p)
{
    qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
    const qcProximity* proximity = &input->proximities[pair->source];
    pair->normal = UnitOrUp(proximity->normal);
    if (pair->swapped)
        pair->normal = qcNegated(pair->normal);
    pair->reported = pair->normal;
    pair->gap = proximity->distance - proximity->depth;
    pair->own = true;
    pair->crossing = pair->relation == qc_relationPenetrating && proximity->depth > 0.0;
    pair->apart = pair->parted = !pair->meets && AreParted(pair);
    qcPairRegion* region = qcManifoldBuilder_PairRegion(m, pair);
    region->crossing = region->crossing || pair->crossing;
    region->unsettled = region->unsettled || !pair->parted;
}

/// Lists the free pairs of each triangle, in their order.
static qcStatus ListPlaces(qcManifoldBuilder* m)
{
    QC_TRY(qcArray_Resize(&m->places, 2 * m->freePairs.count, sizeof(qcManifoldPlace), "pairs of manifolds"));
    uint32_t place = 0;
    for (size_t i = 0; i < m->triangles.count; i++)
    {
        qcManifoldTriangle* triangle = &QC_AT(qcManifoldTriangle, m->triangles, i);
        triangle->first = place;
        for (uint32_t k = 0; k < triangle->pairCount; k++)
        {
            qcPairSide entry = QC_AT(qcPairSide, m->pairsOf, triangle->firstPair + k);
            qcManifoldPair* pair = qcManifoldBuilder_Pair(m, entry.pair);
            if (pair->settled)
                continue;
            uint32_t side = pair->side[0] == triangle ? 0 : 1;
            pair->place[side] = place;
            QC_AT(qcManifoldPlace, m->places, place++) =
                (qcManifoldPlace){.moved = pair->side[1 - side], .gap = pair->gap, .pair = entry.pair};
        }
        triangle->count = place - triangle->first;
    }
    return qc_statusOk;
}

qcStatus qcManifoldBuilder_AskPairs(qcManifoldBuilder* m, qcMeetingInput* input, uint32_t threads)
{
    if (input->proximities == NULL && m->freePairs.count != 0)
    {
        QC_TRY(qcArray_Resize(&m->proximities, input->count, sizeof(qcProximity), "proximities"));
        QC_TRY(qcArray_Resize(&m->feet, input->count, sizeof(qcClosestFeatures), "proximities"));
        Job job = {m, input};
        qcParallel_For(threads, m->freePairs.count, qc_leastPairs, ComputeProximity, &job);
        input->proximities = m->proximities.data;
        input->feet = m->feet.data;
    }
    for (size_t i = 0; i < m->freePairs.count; i++)
        TakeProximity(m, input, qcManifoldBuilder_FreePair(m, i));
    return ListPlaces(m);
}
