// Orientation: the signs of the normals of each region in which some pair is not separated. First relative signs, along
// spanning trees of the most certain links between adjacent pairs (Hoppe, DeRose, Duchamp, McDonald, Stuetzle: Surface
// reconstruction from unorganized points, SIGGRAPH 1992, section 3.3); then the sign of each connected component, by
// the shorter separation distance. The rules, their reasons and limits: plugin/docs/manifolds.md.
#include "manifold/normals.h"
#include "base/scalar.h"
#include "base/status.h"
#include "base/union_find.h"

#include <math.h>

enum
{
    // Room is made for the links of so many pairs at once.
    qc_linkRoom = 64
};

// The cosine of 60 degrees: normals within it, or opposite ones, belong to one surface.
static const double s_linked = 0.5;
// 1 minus the cosine of the angle between normals that differ by rounding only.
static const double s_same = 1e-12;
// A separation distance is clearly shorter than another one by this factor.
static const double s_shorter = 0.75;
// By this one it is certain, also beyond the margin.
static const double s_muchShorter = 0.25;
// The cosine of 15 degrees: the sign of a link between normals within it, or opposite ones, is certain.
static const double s_certain = 0.966;
// A body's centre is on neither side if its weighed distance is less than this.
static const double s_noSide = 0.01;

/// Pairs whose signs are known relative to each other, by the first pair.
typedef struct Component
{
    uint32_t count; ///< 0: its signs are final
    bool isOpposite;
    double along, against;       ///< the longest separation distances of its pairs
    double sumAlong, sumAgainst; ///< their sums
    double size;                 ///< the longest edge
    qcVector normal, position;   ///< sums
} Component;

typedef struct Job
{
    const qcContactInput* input;
    const qcPairOverlaps* overlaps;
    qcPairNormal* normals; ///< by pair
    Component* components; ///< likewise
    uint32_t* nodes;       ///< likewise
    qcArray* links;        ///< of qcSortItem: LinkKey, two pairs
} Job;

static size_t CountPairs(const Job* job)
{
    return job->input->regions->unsettledPairs.count;
}

static uint32_t PairAt(const Job* job, size_t i)
{
    return qcContactRegions_UnsettledPair(job->input->regions, i);
}

static const qcManifoldPair* Pair(const Job* job, uint32_t pair)
{
    return qcContactTopology_Pair(job->input->topology, pair);
}

static const qcRegionProximity* Region(const Job* job, uint32_t pair)
{
    return qcContactProximity_Region(job->input->proximity, Pair(job, pair));
}

//  ---- components -----------------------------------------------------------------------------------------

/// A component of one pair.
static void BeginComponent(const Job* job, uint32_t p)
{
    Component* component = &job->components[p];
    *component = (Component){.count = 1};
    const qcManifoldPair* pair = Pair(job, p);
    const qcProximity* proximity = &job->input->proximity->reported[pair->source];
    const qcRawPoint* corners = qcPairOverlaps_Corners(job->overlaps, p);
    double along = 0.0, against = 0.0;
    for (int i = 0; i < qcPairOverlaps_Count(job->overlaps, p); i++)
    {
        double distance = corners[i].distance;
        along = -distance > along ? -distance : along;
        against = distance > against ? distance : against;
    }
    component->along = component->sumAlong = along;
    component->against = component->sumAgainst = against;
    for (int side = 0; side < 2; side++)
        component->size = qcMax(pair->side[side]->longestEdge, component->size);
    component->normal = job->normals[p].normal;
    component->position = qcPlusScaled(component->position, qcVector_Load(proximity->pointA), 0.5);
    component->position = qcPlusScaled(component->position, qcVector_Load(proximity->pointB), 0.5);
}

/// Adds a component to another one, reversed if it is opposite.
static void AddComponent(const Component* other, bool opposite, Component* component)
{
    component->along = qcMax(component->along, opposite ? other->against : other->along);
    component->against = qcMax(component->against, opposite ? other->along : other->against);
    component->sumAlong += opposite ? other->sumAgainst : other->sumAlong;
    component->sumAgainst += opposite ? other->sumAlong : other->sumAgainst;
    component->size = qcMax(component->size, other->size);
    component->normal = qcPlusScaled(component->normal, other->normal, opposite ? -1.0 : 1.0);
    component->position = qcPlusScaled(component->position, other->position, 1.0);
    component->count += other->count;
}

/// A component's sign is certain if its separation distance along its normals is at most a quarter of that against
/// them (1), or the other way round (-1); 0: it is not certain.
static int CertainSign(const Component* component)
{
    return component->along < s_muchShorter * component->against   ? 1
           : component->against < s_muchShorter * component->along ? -1
                                                                   : 0;
}

/// Joins two components, unless the link is doubtful and contradicts their signs, and these are certain.
static void Join(const Job* job, uint32_t i, uint32_t j, uint32_t opposite, bool doubtful)
{
    uint32_t a = qcUnionFind_Find(job->nodes, i), b = qcUnionFind_Find(job->nodes, j);
    if (a >> 1 == b >> 1)
        return;
    Component *first = &job->components[a >> 1], *second = &job->components[b >> 1];
    bool reversed = (a ^ b ^ opposite) & 1u;
    if (doubtful && CertainSign(first) * CertainSign(second) * (reversed ? -1 : 1) < 0)
        return;
    qcUnionFind_Unite(job->nodes, i, j, opposite);
    if (a >> 1 < b >> 1)
        AddComponent(second, reversed, first);
    else
        AddComponent(first, reversed, second);
}

//  ---- links ----------------------------------------------------------------------------------------------

/// The sort key of a link: the more certain, the lower. The last bit is set if the two normals are opposite.
static uint64_t LinkKey(double dot)
{
    double doubt = 1.0 - fabs(dot);
    return (uint64_t)qcSort_FloatKey(doubt > s_same ? (float)doubt : 0.0f) << 1 | (dot < 0.0);
}

/// Joins a pair with the adjacent pairs of lower numbers where that is certain, and lists the other links; there is
/// room for them.
static void AddLinks(const Job* job, uint32_t p, int side)
{
    uint32_t *nodes = job->nodes, root = qcUnionFind_Find(nodes, p) >> 1;
    const qcPairNormal* own = &job->normals[p];
    qcAdjacentPairs adjacent = qcPairAdjacency_Of(job->input->adjacency, p, side);
    for (uint32_t i = 0; i < adjacent.count; i++)
    {
        uint32_t q = qcPairAdjacency_Side(job->input->adjacency, adjacent.entries[i])->pair;
        if (q >= p || nodes[q] >> 1 == root || qcUnionFind_Find(nodes, q) >> 1 == root)
            continue;
        const qcPairNormal* other = &job->normals[q];
        double dot = qcDot(own->normal, other->normal);
        if (dot >= s_linked && own->disjoint && other->disjoint)
        {
            Join(job, q, p, 0, false);
            root = qcUnionFind_Find(nodes, p) >> 1;
        }
        else if (fabs(dot) >= s_linked)
            QC_AT(qcSortItem, *job->links, job->links->count++) = (qcSortItem){LinkKey(dot), (uint64_t)q << 32 | p};
    }
}

static void JoinLink(const Job* job, qcSortItem link)
{
    bool doubtful = link.key >> 1 > LinkKey(s_certain) >> 1;
    Join(job, (uint32_t)(link.value >> 32), (uint32_t)link.value, link.key & 1u, doubtful);
}

/// Joins the links between equal normals, which come first in the order of certainty; then drops those whose ends are
/// joined.
static void DropJoinedLinks(const Job* job)
{
    uint64_t same = LinkKey(1.0);
    qcSortItem* links = job->links->data;
    size_t kept = 0;
    for (size_t i = 0; i < job->links->count; i++)
        if (links[i].key == same)
            JoinLink(job, links[i]);
    for (size_t i = 0; i < job->links->count; i++)
    {
        uint32_t first = (uint32_t)(links[i].value >> 32), second = (uint32_t)links[i].value;
        if (qcUnionFind_Find(job->nodes, first) >> 1 != qcUnionFind_Find(job->nodes, second) >> 1)
            links[kept++] = links[i];
    }
    job->links->count = kept;
}

/// Joins all disjoint pairs of each ambiguous region in which nothing penetrates: they keep their signs. The first one
/// is the region's reference. `references`: by region, the pair or UINT32_MAX.
static void JoinDisjointPairs(const Job* job, uint32_t* references)
{
    for (uint32_t r = 0; r < job->input->topology->regionCount; r++)
        references[r] = UINT32_MAX;
    for (size_t i = 0; i < CountPairs(job); i++)
    {
        uint32_t p = PairAt(job, i);
        uint32_t* reference = &references[Pair(job, p)->region];
        if (!job->normals[p].disjoint || !Region(job, p)->ambiguous || Region(job, p)->penetrating)
            continue;
        if (*reference == UINT32_MAX)
            *reference = p;
        Join(job, *reference, p, 0, false);
    }
}

/// Grows spanning trees of pairs whose signs are equal or opposite: by disjoint pairs, then by certain links, then by
/// the others in the order of their certainty.
static qcStatus GrowComponents(const Job* job, uint32_t* references, qcArray* sortScratch)
{
    for (size_t i = 0; i < CountPairs(job); i++)
    {
        uint32_t p = PairAt(job, i);
        job->nodes[p] = p << 1;
        if (Region(job, p)->ambiguous)
            BeginComponent(job, p);
        else
            job->components[p].count = 0;
    }
    JoinDisjointPairs(job, references);
    job->links->count = 0;
    for (size_t i = 0; i < CountPairs(job); i++)
    {
        uint32_t p = PairAt(job, i);
        if (i % qc_linkRoom == 0)
            QC_TRY(qcArray_Reserve(job->links, job->links->count + (size_t)2 * qc_linkRoom * qc_maxAdjacentPairs,
                                   sizeof(qcSortItem), "orientation of normals"));
        for (int side = 0; side < 2 && Region(job, p)->ambiguous; side++)
            AddLinks(job, p, side);
    }
    DropJoinedLinks(job);
    QC_TRY(qcSort_Items(job->links->data, job->links->count, sortScratch));
    for (size_t i = 0; i < job->links->count; i++)
        JoinLink(job, QC_AT(qcSortItem, *job->links, i));
    return qc_statusOk;
}

//  ---- signs ----------------------------------------------------------------------------------------------

static void Flip(qcPairNormal* normal)
{
    normal->normal = qcNegated(normal->normal);
    normal->flipped = !normal->flipped;
}

/// Makes the signs of each component consistent with its first pair. A component with the region's reference takes the
/// reference's sign instead: its signs are final.
static void MakeConsistent(const Job* job, const uint32_t* references)
{
    for (size_t i = 0; i < CountPairs(job); i++)
    {
        uint32_t p = PairAt(job, i);
        if (!Region(job, p)->ambiguous)
            continue;
        uint32_t root = qcUnionFind_Find(job->nodes, p), reference = references[Pair(job, p)->region];
        if (reference != UINT32_MAX)
            reference = qcUnionFind_Find(job->nodes, reference);
        bool isFinal = reference >> 1 == root >> 1;
        if ((isFinal ? root ^ reference : root) & 1u)
            Flip(&job->normals[p]);
        if (isFinal)
            job->components[root >> 1].count = 0;
    }
}

/// A corner of a body's box, in the unit of this build.
static qcVector ScaledCorner(const double corner[3], int exponent)
{
    if (exponent == 0)
        return qcVector_Load(corner);
    return (qcVector){ldexp(corner[0], -exponent), ldexp(corner[1], -exponent), ldexp(corner[2], -exponent)};
}

static qcVector CentreOf(const qcBody* body, int exponent)
{
    qcVector lower = ScaledCorner(body->lower, exponent), upper = ScaledCorner(body->upper, exponent);
    return (qcVector){0.5 * lower.x + 0.5 * upper.x, 0.5 * lower.y + 0.5 * upper.y, 0.5 * lower.z + 0.5 * upper.z};
}

static double Size2(const qcBody* body, int exponent)
{
    qcVector diagonal = qcMinus(ScaledCorner(body->upper, exponent), ScaledCorner(body->lower, exponent));
    return qcDot(diagonal, diagonal);
}

/// The side of the bodies' centres. Above 0: the sides that the normals give; below 0: the opposite sides; 0: neither
/// clearly.
static double SideOfBodies(const Component* component, const qcManifoldPair* pair, int exponent)
{
    double length = sqrt(qcDot(component->normal, component->normal));
    // If normals point all around a body, there is no common side.
    const qcBody *bodyA = pair->side[0]->body, *bodyB = pair->side[1]->body;
    if (bodyA == bodyB || !(length > 0.5 * component->count))
        return 0.0;
    qcVector zero = {0.0, 0.0, 0.0};
    qcVector position = qcPlusScaled(zero, component->position, 1.0 / component->count);
    double a2 = Size2(bodyA, exponent), b2 = Size2(bodyB, exponent);
    double a = qcDot(qcMinus(CentreOf(bodyA, exponent), position), component->normal) / length;
    double b = qcDot(qcMinus(CentreOf(bodyB, exponent), position), component->normal) / length;
    double smaller2 = fmin(a2, b2);
    // Distances as shares of the bodies' sizes, weighed by one over their squares. With less weight a ring on the floor
    // of a deep bin would be pushed out through the floor, since the centre of the bin is far above.
    double side = (a2 > 0.0 ? a / (a2 * sqrt(a2)) : 0.0) - (b2 > 0.0 ? b / (b2 * sqrt(b2)) : 0.0);
    return fabs(side) * smaller2 > s_noSide ? side : 0.0;
}

static bool PointsDown(qcVector n)
{
    return n.x != 0.0 ? n.x < 0.0 : n.y != 0.0 ? n.y < 0.0 : n.z < 0.0;
}

static bool IsOpposite(const Job* job, const Component* component, uint32_t first)
{
    double shorter = fmin(component->along, component->against), longer = fmax(component->along, component->against);
    double rounding = QC_MANIFOLD_ROUNDING * component->size;
    if (shorter < (shorter <= job->input->margin + rounding ? s_shorter : s_muchShorter) * longer - rounding)
        return component->against < component->along;
    double bodies = SideOfBodies(component, Pair(job, first), job->input->topology->exponent);
    if (bodies != 0.0)
        return bodies < 0.0;
    if (fabs(component->sumAlong - component->sumAgainst) > rounding * component->count)
        return component->sumAgainst < component->sumAlong;
    return PointsDown(job->normals[first].normal);
}

static void FlipOppositeComponents(const Job* job)
{
    for (size_t i = 0; i < CountPairs(job); i++)
    {
        uint32_t p = PairAt(job, i);
        Component* component = &job->components[p];
        component->isOpposite = component->count != 0 && IsOpposite(job, component, p);
    }
    for (size_t i = 0; i < CountPairs(job); i++)
    {
        uint32_t p = PairAt(job, i);
        if (job->components[qcUnionFind_Find(job->nodes, p) >> 1].isOpposite)
            Flip(&job->normals[p]);
    }
}

qcStatus qcContactNormals_Orient(const qcContactInput* input, const qcPairOverlaps* overlaps, qcContactNormals* normals)
{
    bool ambiguous = false;
    for (uint32_t r = 0; r < input->topology->regionCount; r++)
        ambiguous = ambiguous || QC_AT(qcRegionProximity, input->proximity->regions, r).ambiguous;
    if (!ambiguous)
        return qc_statusOk;
    size_t count = input->topology->pairs.count, regions = input->topology->regionCount;
    QC_TRY(qcArray_Resize(&normals->components, count, sizeof(Component), "orientation of normals"));
    QC_TRY(qcArray_Resize(&normals->nodes, count, sizeof(uint32_t), "orientation of normals"));
    QC_TRY(qcArray_Resize(&normals->references, regions, sizeof(uint32_t), "orientation of normals"));
    Job job = {.input = input,
               .overlaps = overlaps,
               .normals = normals->pairs.data,
               .components = normals->components.data,
               .nodes = normals->nodes.data,
               .links = &normals->items};
    QC_TRY(GrowComponents(&job, normals->references.data, &normals->sortScratch));
    MakeConsistent(&job, normals->references.data);
    FlipOppositeComponents(&job);
    return qc_statusOk;
}
