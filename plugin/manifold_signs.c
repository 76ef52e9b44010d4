// The signs of the normals, looked at in each region.
//
// Relative signs: along a tree that reaches every pair of the region over the links that are surest, the next normal
// is turned to agree with the one before. Surest: two pairs that are apart and agree already; then the links in order
// of how parallel the two normals are. After Hoppe, DeRose, Duchamp, McDonald,
// Stuetzle: Surface reconstruction from unorganized points, SIGGRAPH 1992, section 3.3. Where nothing in a region
// crosses, the pairs that are apart keep their signs whatever the tree says: they are facts, also where a sheet in a
// slit has facts that are opposite. Where something crosses, a pair that is apart may lie behind the sheet that it
// crossed: then it is turned, and its distance becomes a depth.
//
// The sign of the region: that with the shorter way out: so far one side has to move along the normals until it lies
// above the other in all pairs, or against them until it lies below. The pairs
// know both sides no farther than the margin. Where the shorter way is longer than that (or both are the same, as in
// one plane), the bodies decide: each lies on the side on which the centre of its box is, the smaller body weighing
// more, since a large one is often concave around the contact. A body with itself has no such sides.
//
// Limits: with no margin and triangles smaller than the depth, two concave bodies hooked into each other can be told
// to go the wrong way; and a one-sided region (a Moebius strip of contact) has an edge at which signs flip.
#include "manifold_parts.h"
#include "sort.h"
#include "status.h"

#include <math.h>
#include <string.h>

// Normals of pairs that are apart and less than 60 degrees from each other go on around a corner.
static const double s_agree = 0.5;
// Ways out that differ by less are the same but for rounding.
static const double s_sameWay = 1e-6;
// A centre that lies nearer to the contact, by the size of the smaller box, is on no side.
static const double s_noSide = 0.01;

/// What is known of a region while its sign is looked for; by its first pair.
typedef struct Region
{
    bool unsettled; ///< some pair is not a fact
    bool crossing, wrongWay;
    uint32_t fact; ///< its first pair that is apart, or UINT32_MAX
    double along, against;
    qcVector normal, place; ///< sums
    uint32_t count;
} Region;

static Region* RegionOf(const qcManifolds* m, uint32_t pair)
{
    return &QC_AT(Region, m->regions, qcManifolds_Pair(m, pair)->region);
}

static qcStatus LookAtRegions(qcManifolds* m, bool* unsettled)
{
    size_t count = m->work.count;
    QC_TRY(qcArray_Resize(&m->regions, count, sizeof(Region), "regions of contact"));
    *unsettled = false;
    for (uint32_t p = 0; p < count; p++)
        QC_AT(Region, m->regions, p) = (Region){.fact = UINT32_MAX};
    for (uint32_t p = 0; p < count; p++)
    {
        const qcManifoldPair* pair = qcManifolds_Pair(m, p);
        Region* region = RegionOf(m, p);
        region->crossing = region->crossing || pair->crossing;
        if (!pair->apart)
            region->unsettled = *unsettled = true;
        else if (region->fact == UINT32_MAX)
            region->fact = p;
    }
    return qc_statusOk;
}

/// The pairs that are apart hold together in regions in which nothing crosses.
static void UniteFacts(qcManifolds* m)
{
    uint32_t* nodes = m->nodes.data;
    for (uint32_t p = 0; p < m->work.count; p++)
        nodes[p] = p << 1;
    for (uint32_t p = 0; p < m->work.count; p++)
        if (qcManifolds_Pair(m, p)->apart && !RegionOf(m, p)->crossing)
            qcSigned_Unite(nodes, RegionOf(m, p)->fact, p, 0);
}

/// Links of the pairs that have a key in common, each with the one before; the surest first.
static qcStatus ListLinks(qcManifolds* m)
{
    m->order.count = 0;
    const qcSortItem* items = m->items.data;
    for (size_t i = 1; i < m->items.count; i++)
    {
        uint32_t p = (uint32_t)(items[i - 1].value / qc_besideKeys), q = (uint32_t)(items[i].value / qc_besideKeys);
        if (items[i].key != items[i - 1].key || !RegionOf(m, p)->unsettled)
            continue;
        const qcManifoldPair *a = qcManifolds_Pair(m, p), *b = qcManifolds_Pair(m, q);
        double dot = qcDot(a->normal, b->normal);
        float doubt = a->apart && b->apart && dot > s_agree ? -1.0f : (float)(1.0 - fabs(dot));
        QC_TRY(qcArray_Reserve(&m->order, m->order.count + 1, sizeof(qcSortItem), "signs of normals"));
        QC_AT(qcSortItem, m->order, m->order.count++) =
            (qcSortItem){(uint64_t)qcSort_FloatKey(doubt) << 1 | (dot < 0.0), (uint64_t)p << 32 | q};
    }
    return qcSort_Items(m->order.data, m->order.count, &m->scratch);
}

static void Turn(qcManifoldPair* pair)
{
    pair->normal = qcNegated(pair->normal);
    pair->turned = !pair->turned;
}

/// Turns pairs so that those of a region agree with its first one; or, where facts hold, with these.
static void Agree(qcManifolds* m)
{
    uint32_t* nodes = m->nodes.data;
    for (size_t i = 0; i < m->order.count; i++)
    {
        qcSortItem link = QC_AT(qcSortItem, m->order, i);
        qcSigned_Unite(nodes, (uint32_t)(link.value >> 32), (uint32_t)link.value, link.key & 1u);
    }
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        const Region* region = RegionOf(m, p);
        if (!region->unsettled)
            continue;
        uint32_t opposite = qcSigned_Find(nodes, p) & 1u;
        if (!region->crossing && region->fact != UINT32_MAX)
            opposite ^= qcSigned_Find(nodes, region->fact) & 1u;
        if (opposite)
            Turn(qcManifolds_Pair(m, p));
    }
}

static void SumUp(qcManifolds* m, const qcProximity* proximities)
{
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        const qcManifoldPair* pair = qcManifolds_Pair(m, p);
        Region* region = RegionOf(m, p);
        if (!region->unsettled)
            continue;
        qcRawPoint corners[qc_maxCommonCorners];
        int count = qcManifoldPair_FindCommonPart(pair, pair->normal, corners);
        for (int i = 0; i < count; i++)
        {
            region->along = fmax(region->along, -corners[i].distance);
            region->against = fmax(region->against, corners[i].distance);
        }
        region->normal = qcPlusScaled(region->normal, pair->normal, 1.0);
        region->place = qcPlusScaled(region->place, qcVector_Load(proximities[pair->source].pointA), 0.5);
        region->place = qcPlusScaled(region->place, qcVector_Load(proximities[pair->source].pointB), 0.5);
        region->count++;
    }
}

static qcVector CentreOf(const qcBody* body)
{
    return (qcVector){0.5 * body->lower[0] + 0.5 * body->upper[0], 0.5 * body->lower[1] + 0.5 * body->upper[1],
                      0.5 * body->lower[2] + 0.5 * body->upper[2]};
}

static double Size2(const qcBody* body)
{
    qcVector diagonal = qcMinus(qcVector_Load(body->upper), qcVector_Load(body->lower));
    return qcDot(diagonal, diagonal);
}

/// Above 0: the bodies lie as the normals say; below: the other way round; 0: they don't say.
static double SideOfBodies(const Region* region, const qcManifoldPair* pair)
{
    double length = sqrt(qcDot(region->normal, region->normal));
    // Normals all around a body have no common side.
    if (pair->slot[0] == pair->slot[1] || !(length > 0.5 * region->count))
        return 0.0;
    qcVector zero = {0.0, 0.0, 0.0};
    qcVector place = qcPlusScaled(zero, region->place, 1.0 / region->count);
    double a2 = Size2(pair->body[0]), b2 = Size2(pair->body[1]);
    double a = qcDot(qcMinus(CentreOf(pair->body[0]), place), region->normal) / length;
    double b = qcDot(qcMinus(CentreOf(pair->body[1]), place), region->normal) / length;
    double smaller = sqrt(fmin(a2, b2));
    // Each as a share of the body's size, and the shares weighed by one over the size.
    double side = (a2 > 0.0 ? a / a2 : 0.0) - (b2 > 0.0 ? b / b2 : 0.0);
    return fabs(side) * smaller > s_noSide ? side : 0.0;
}

static bool PointsDown(qcVector n)
{
    return n.x != 0.0 ? n.x < 0.0 : n.y != 0.0 ? n.y < 0.0 : n.z < 0.0;
}

static bool IsWrongWay(const Region* region, const qcManifoldPair* first, double margin)
{
    double shorter = fmin(region->along, region->against), longer = fmax(region->along, region->against);
    bool differ = longer - shorter > s_sameWay * longer;
    double bodies = SideOfBodies(region, first);
    if (bodies != 0.0 && !(differ && shorter <= margin + s_sameWay * longer))
        return bodies < 0.0;
    return differ ? region->against < region->along : PointsDown(first->normal);
}

qcStatus qcManifolds_ChooseSigns(qcManifolds* m, const qcProximity* proximities, double margin)
{
    bool unsettled = false;
    QC_TRY(LookAtRegions(m, &unsettled));
    if (!unsettled)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&m->nodes, m->work.count, sizeof(uint32_t), "signs of normals"));
    UniteFacts(m);
    QC_TRY(ListLinks(m));
    Agree(m);
    SumUp(m, proximities);
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        Region* region = &QC_AT(Region, m->regions, p);
        bool factsDecide = !region->crossing && region->fact != UINT32_MAX;
        region->wrongWay = region->unsettled && !factsDecide && IsWrongWay(region, qcManifolds_Pair(m, p), margin);
    }
    for (uint32_t p = 0; p < m->work.count; p++)
        if (RegionOf(m, p)->wrongWay)
            Turn(qcManifolds_Pair(m, p));
    return qc_statusOk;
}
