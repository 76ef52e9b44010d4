// The normal of each pair, from the pair itself and those adjacent to it. In parallel. A pair keeps the normal of its
// proximity if that costs nothing, or as little as any other. Otherwise it takes the cheapest of: the reported one, its
// opposite, the normals of its two faces, and that of the adjacent pair with the smallest signed distance.
//
// A closest point may lie on an edge or a vertex whose other triangles are closer: the pair is then no local minimum of
// the distance of the surfaces (Johnson, Cohen: Spatialized normal cone hierarchies, 2001), and its own normal is no
// candidate. Reasons and limits: plugin/docs/manifolds.md.
#include "manifold/normal_cost.h"
#include "manifold/stage_switches.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <math.h>

// Another pair must be closer by this factor, so that rounding never decides.
static const double s_closer = 1.0 - 1e-6;

typedef struct Job
{
    const qcContactInput* input;
    qcPairOverlaps* overlaps;
    qcContactNormals* normals;
} Job;

/// The best candidate so far.
typedef struct Best
{
    qcVector normal;
    double cost;
    bool isReported; ///< no other candidate was better
    bool opposite;   ///< the overlap is along the opposite of the normal
    qcProjectedOverlap *overlap, *spare;
} Best;

/// A separated pair takes no normal that makes it a contact: along the normal, or along its opposite, the projected
/// triangles are disjoint, or side 0 lies above side 1.
static bool IsAllowed(const qcContactInput* input, const qcNeighbourhood* n, const qcNormalCandidate* candidate,
                      bool opposite)
{
    const qcSeparation* separation = &candidate->separation;
    if (!n->proximity->separated || (opposite ? separation->against : separation->along) <= 0.0)
        return true;
    qcProjectedOverlap_Compute(input->kernels, n->pair, candidate->normal, candidate->overlap);
    double rounding = qcManifoldPair_Rounding(n->pair);
    return opposite ? candidate->overlap->high <= rounding : candidate->overlap->low >= -rounding;
}

static void TakeIfBetter(const qcContactInput* input, const qcNeighbourhood* n, const qcNormalCandidate* candidate,
                         bool opposite, Best* best)
{
    double cost = opposite ? candidate->against : candidate->along;
    if (!(cost < qcNeighbourhood_Limit(n, best->cost)) || !IsAllowed(input, n, candidate, opposite))
        return;
    best->normal = opposite ? qcNegated(candidate->normal) : candidate->normal;
    best->cost = cost;
    best->isReported = false;
    best->opposite = opposite;
    if (best->overlap != candidate->overlap)
    {
        best->spare = best->overlap;
        best->overlap = candidate->overlap;
    }
}

/// Evaluates a normal and its opposite.
static void Evaluate(const qcContactInput* input, const qcNeighbourhood* n, qcVector normal, int face, Best* best)
{
    qcNormalCandidate candidate = {.normal = normal, .face = face, .overlap = best->spare};
    double limit = qcNeighbourhood_Limit(n, best->cost);
    if (!(limit > 0.0) || !qcNeighbourhood_FindCost(n, limit, &candidate))
        return;
    candidate.overlap->count = -1;
    TakeIfBetter(input, n, &candidate, false, best);
    TakeIfBetter(input, n, &candidate, true, best);
}

/// The two faces, the one more along the reported normal first, so that the result does not depend on the order of the
/// sides.
static void EvaluateFaces(const qcContactInput* input, const qcNeighbourhood* n, Best* best)
{
    qcVector reported = n->proximity->normal;
    qcVector faces[2];
    bool isFace[2];
    for (int side = 0; side < 2; side++)
    {
        faces[side] = n->pair->side[side]->normal;
        isFace[side] = qcDot(faces[side], faces[side]) > 0.0;
        if (!isFace[side])
            faces[side] = reported;
    }
    int first = fabs(qcDot(faces[1], reported)) > fabs(qcDot(faces[0], reported)), second = 1 - first;
    Evaluate(input, n, faces[first], isFace[first] ? first : -1, best);
    Evaluate(input, n, faces[second], isFace[second] ? second : -1, best);
}

static bool HasVertex(const qcManifoldTriangle* triangle, uint32_t v)
{
    return triangle->vertex[0] == v || triangle->vertex[1] == v || triangle->vertex[2] == v;
}

/// True if a closer adjacent pair contains both closest features: one lies on the common triangle, the other must lie
/// on the adjacent pair's other triangle.
static bool HasCloserNeighbour(const qcNeighbourhood* n, const qcClosestFeatures* features)
{
    double closer = s_closer * n->proximity->gap;
    for (int side = 0; side < 2; side++)
    {
        const qcManifoldTriangle* own = n->pair->side[1 - side];
        unsigned corners = features->corners[(side == 0) != n->pair->swapped ? 1 : 0];
        for (uint32_t i = 0; i < n->adjacent[side].count; i++)
        {
            const qcPairSide* other = qcPairAdjacency_Side(n->adjacency, n->adjacent[side].entries[i]);
            bool found = other->gap < closer;
            for (unsigned c = 0; c < 3 && found; c++)
                found = !(corners >> c & 1u) || HasVertex(other->other, own->vertex[c]);
            if (found)
                return true;
        }
    }
    return false;
}

static void FindLocalMinima(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    const qcContactInput* input = job->input;
    for (size_t i = block * qc_normalBlock; i < qcNormalBlocks_End(input, block); i++)
    {
        uint32_t p = qcContactRegions_UnsettledPair(input->regions, i);
        bool* isNoLocalMinimum = &qcContactNormals_Pair(job->normals, p)->isNoLocalMinimum;
        *isNoLocalMinimum = false;
        if (!qcContactProximity_Pair(input->proximity, p)->separated || !QC_STAGE_RUNS(localMinimum))
            continue;
        qcNeighbourhood n = qcNeighbourhood_Of(input, p);
        *isNoLocalMinimum = HasCloserNeighbour(&n, &input->proximity->features[n.pair->source]);
    }
}

/// The adjacent pair with the smallest signed distance, or the pair itself. A separated pair does not take the normal
/// of an intersecting one, which may be wrong itself. Pairs that are no local minimum are skipped.
static uint32_t ClosestAround(const Job* job, const qcNeighbourhood* n, uint32_t pair)
{
    uint32_t closest = pair;
    double gap = n->proximity->gap;
    for (int side = 0; side < 2; side++)
        for (uint32_t i = 0; i < n->adjacent[side].count; i++)
        {
            const qcPairSide* other = qcPairAdjacency_Side(n->adjacency, n->adjacent[side].entries[i]);
            bool closer = other->gap < gap || (!(other->gap > gap) && other->pair < closest);
            if (!closer || qcContactNormals_Pair(job->normals, other->pair)->isNoLocalMinimum)
                continue;
            if (n->proximity->separated && !qcContactProximity_Pair(job->input->proximity, other->pair)->separated)
                continue;
            closest = other->pair;
            gap = other->gap;
        }
    return closest;
}

static void ChooseNormal(const Job* job, uint32_t pair, Best* best)
{
    const qcContactInput* input = job->input;
    qcNeighbourhood n = qcNeighbourhood_Of(input, pair);
    *best = (Best){.normal = n.proximity->normal,
                   .cost = INFINITY,
                   .isReported = true,
                   .overlap = best->overlap,
                   .spare = best->spare};
    best->overlap->count = -1;
    if (!qcContactNormals_Pair(job->normals, pair)->isNoLocalMinimum)
    {
        qcNormalCandidate reported = {.normal = best->normal, .face = -1, .overlap = best->overlap};
        qcNeighbourhood_FindCost(&n, INFINITY, &reported);
        best->cost = reported.along;
        if (reported.along <= n.rounding || !QC_STAGE_RUNS(neighbourCost))
            return;
        TakeIfBetter(input, &n, &reported, true, best);
    }
    EvaluateFaces(input, &n, best);
    uint32_t closest = qcNeighbourhood_Limit(&n, best->cost) > 0.0 ? ClosestAround(job, &n, pair) : pair;
    if (closest != pair)
        Evaluate(input, &n, qcContactProximity_Pair(input->proximity, closest)->normal, -1, best);
}

static void ChooseBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    const qcContactInput* input = job->input;
    qcProjectedOverlap overlaps[2];
    Best best = {.overlap = &overlaps[0], .spare = &overlaps[1]};
    if (!qcPairOverlaps_Reserve(job->overlaps, worker, (size_t)qc_normalBlock * qc_maxOverlapCorners))
        return;
    for (size_t i = block * qc_normalBlock; i < qcNormalBlocks_End(input, block); i++)
    {
        uint32_t p = qcContactRegions_UnsettledPair(input->regions, i);
        const qcManifoldPair* pair = qcContactTopology_Pair(input->topology, p);
        ChooseNormal(job, p, &best);
        qcProjectedOverlap_Compute(input->kernels, pair, best.opposite ? qcNegated(best.normal) : best.normal,
                                   best.overlap);
        // Field by field, since other threads read isNoLocalMinimum.
        qcPairNormal* normal = qcContactNormals_Pair(job->normals, p);
        normal->normal = best.normal;
        normal->cost = best.cost;
        normal->round = 0;
        normal->changed = normal->intersecting = normal->reliable = false;
        normal->flipped = false;
        normal->disjoint =
            qcContactProximity_Pair(input->proximity, p)->separated && (best.isReported || best.overlap->count != 0);
        qcPairOverlaps_Set(job->overlaps, p, worker, best.overlap, best.normal, best.opposite,
                           qcContactInput_CornerLimit(input, pair));
    }
}

qcStatus qcContactNormals_Choose(const qcContactInput* input, qcPairOverlaps* overlaps, qcContactNormals* normals)
{
    // Each pair reads the proximities of others, but no normal that another pair has chosen: the order does not matter.
    Job job = {input, overlaps, normals};
    size_t blocks = qcNormalBlocks_Count(input);
    qcParallel_For(input->threads, blocks, qc_minNormalBlocks, FindLocalMinima, &job);
    qcParallel_For(input->threads, blocks, qc_minNormalBlocks, ChooseBlock, &job);
    return qcPairOverlaps_Status(overlaps);
}
