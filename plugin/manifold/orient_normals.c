// The signs of the normals. Only regions in which some pair touches or penetrates have a choice.
//
// Relative signs: along trees of the surest links between neighbours, each normal is turned to agree with the one
// before. Surest: two pairs that are apart and agree already; then the links in order of how parallel the two normals
// are. Every pair is linked to all those beside it: trees along a few of these links cross where a surer way leads
// around. Most links need no place in the order, since their ends are joined before. After Hoppe, DeRose, Duchamp,
// McDonald, Stuetzle: Surface reconstruction from unorganized points, SIGGRAPH 1992, section 3.3. Normals more than 60
// degrees from each other and from each other's opposite say nothing of each other's sign (a floor and a wall): what no
// other links connect has signs of its own, and is a part.
//
// Where nothing in a region crosses, the pairs that are apart keep their signs whatever the tree says: they are facts,
// also where a sheet in a slit has facts that are opposite. Where something crosses, a pair that is apart may lie
// behind the sheet that it crossed: then it is turned, and its distance becomes a depth.
//
// A part knows its side if the way out along its normals is a quarter of that against them, or less. Two parts that
// know theirs are not made one by a link that says otherwise between normals 15 degrees or more from each other: around
// the rim of a shared cut, where pairs part sideways, such links lead from one side of an edge to the other, and a pair
// that is a millionth of its size deep would be told to go through the whole of a body.
//
// The sign of a part: that with the shorter way out, so far side 0 has to move along the normals until it lies above
// side 1 in all pairs, or against them until it lies below. The pairs know both sides of a crossing no farther than the
// margin: they are asked first, and believed if the shorter way is within the margin, and clearly shorter, or a quarter
// of the other one. Otherwise two bodies decide: each lies on the side on which the centre of its box is, the smaller
// body weighing more, since a large one is often concave around the contact. If these say nothing either, as of a body
// with itself, the sum of the ways out of all pairs decides, which is less sure than the longest one (of a box sunk
// into a floor, the bottom has more pairs than the walls), but not at the mercy of a single pair.
//
// Limits: where bodies have sunk into each other deeper than the margin, two concave ones that are hooked into each
// other can be told to go the wrong way; and a one-sided part (a Moebius strip of contact) has an edge at which signs
// flip.
#include "manifold/manifold_builder.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

enum
{
    // Room is made for the links of so many pairs at once.
    qc_linkRoom = 64
};

// The cosine of 60 degrees: normals nearer to each other, or to each other's opposite, are one surface's.
static const double s_agree = 0.5;
// One less a cosine that is nothing but rounding.
static const double s_same = 1e-12;
// A way out is clearly shorter than another one by this factor.
static const double s_shorter = 0.75;
// And much shorter by this one: believed beyond the margin.
static const double s_muchShorter = 0.25;
// The cosine of 15 degrees: normals nearer to each other, or to each other's opposite, are surely one surface's.
static const double s_surface = 0.966;
// A centre that lies nearer to the contact, by the size of the smaller box, is on no side.
static const double s_noSide = 0.01;

/// A part of a region, by its first pair.
typedef struct Part
{
    uint32_t count;
    bool wrongWay;
    double along, against;       ///< the longest ways out of its pairs
    double sumAlong, sumAgainst; ///< of the ways out
    double size;                 ///< the longest edge
    qcVector normal, place;      ///< sums
} Part;

/// False: nothing has a choice.
static bool FindFacts(qcManifoldBuilder* m)
{
    bool unsettled = false;
    for (size_t i = 0; i < m->freePairs.count; i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(m, i);
        const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        qcPairRegion* region = qcManifoldBuilder_PairRegion(m, pair);
        unsettled = unsettled || region->unsettled;
        if (pair->apart && region->fact == UINT32_MAX)
            region->fact = p;
    }
    return unsettled;
}

/// The surer, the lower; the last bit says that the two are opposite.
static uint64_t LinkKey(double dot)
{
    double doubt = 1.0 - fabs(dot);
    return (uint64_t)qcSort_FloatKey(doubt > s_same ? (float)doubt : 0.0f) << 1 | (dot < 0.0);
}

/// A part of one pair.
static void MakePart(Part* part, const qcManifoldBuilder* m, uint32_t p, const qcProximity* proximity)
{
    *part = (Part){.count = 1};
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
    const qcRawPoint* corners = qcManifoldBuilder_Corners(m, p);
    double along = 0.0, against = 0.0;
    for (int i = 0; i < QC_AT(qcPairCorners, m->corners, p).count; i++)
    {
        double distance = corners[i].distance;
        along = -distance > along ? -distance : along;
        against = distance > against ? distance : against;
    }
    part->along = part->sumAlong = along;
    part->against = part->sumAgainst = against;
    for (int side = 0; side < 2; side++)
        part->size = pair->side[side]->longestEdge > part->size ? pair->side[side]->longestEdge : part->size;
    part->normal = pair->normal;
    part->place = qcPlusScaled(part->place, qcVector_Load(proximity->pointA), 0.5);
    part->place = qcPlusScaled(part->place, qcVector_Load(proximity->pointB), 0.5);
}

static double Larger(double x, double y)
{
    return x > y ? x : y;
}

/// Adds a part to another one, turned around if it is opposite.
static void AddPart(Part* part, const Part* other, bool opposite)
{
    part->along = Larger(part->along, opposite ? other->against : other->along);
    part->against = Larger(part->against, opposite ? other->along : other->against);
    part->sumAlong += opposite ? other->sumAgainst : other->sumAlong;
    part->sumAgainst += opposite ? other->sumAlong : other->sumAgainst;
    part->size = Larger(part->size, other->size);
    part->normal = qcPlusScaled(part->normal, other->normal, opposite ? -1.0 : 1.0);
    part->place = qcPlusScaled(part->place, other->place, 1.0);
    part->count += other->count;
}

/// Above 0: the part lies as its normals say, since the way out along them is much the shorter; below: the other way
/// round; 0: it doesn't know.
static int SideOf(const Part* part)
{
    return part->along < s_muchShorter * part->against ? 1 : part->against < s_muchShorter * part->along ? -1 : 0;
}

/// Makes two parts one, with what is known of both; but not by a doubtful link if both know their side and it says
/// otherwise.
static void Join(qcManifoldBuilder* m, uint32_t i, uint32_t j, uint32_t opposite, bool doubtful)
{
    uint32_t a = qcSigned_Find(m->nodes.data, i), b = qcSigned_Find(m->nodes.data, j);
    if (a >> 1 == b >> 1)
        return;
    Part *first = &QC_AT(Part, m->parts, a >> 1), *second = &QC_AT(Part, m->parts, b >> 1);
    bool turned = (a ^ b ^ opposite) & 1u;
    if (doubtful && SideOf(first) * SideOf(second) * (turned ? -1 : 1) < 0)
        return;
    qcSigned_Unite(m->nodes.data, i, j, opposite);
    if (a >> 1 < b >> 1)
        AddPart(first, second, turned);
    else
        AddPart(second, first, turned);
}

/// Unites a pair with those before it beside it where that is sure, and lists the other links; there is room for them.
static void TakeLinks(qcManifoldBuilder* m, uint32_t p, int side)
{
    uint32_t *nodes = m->nodes.data, root = qcSigned_Find(nodes, p) >> 1;
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
    qcRing ring = qcManifoldBuilder_Ring(m, pair, side);
    for (uint32_t i = 0; i < ring.count; i++)
    {
        uint32_t q = qcManifoldBuilder_Beside(m, ring.entries[i])->pair;
        if (q >= p || nodes[q] >> 1 == root || qcSigned_Find(nodes, q) >> 1 == root)
            continue;
        const qcManifoldPair* other = qcManifoldBuilder_Pair(m, q);
        double dot = qcDot(pair->normal, other->normal);
        if (dot >= s_agree && pair->apart && other->apart)
        {
            Join(m, q, p, 0, false);
            root = qcSigned_Find(nodes, p) >> 1;
        }
        else if (fabs(dot) >= s_agree)
            QC_AT(qcSortItem, m->order, m->order.count++) = (qcSortItem){LinkKey(dot), (uint64_t)q << 32 | p};
    }
}

static void UniteLink(qcManifoldBuilder* m, qcSortItem link)
{
    bool doubtful = link.key >> 1 > LinkKey(s_surface) >> 1;
    Join(m, (uint32_t)(link.value >> 32), (uint32_t)link.value, link.key & 1u, doubtful);
}

/// Of the links that were listed, unites those of one and the same normal, which come first in their order. Of the
/// others those stay that still join something.
static void DropLinks(qcManifoldBuilder* m)
{
    uint32_t* nodes = m->nodes.data;
    uint64_t same = LinkKey(1.0);
    size_t stay = 0;
    for (size_t i = 0; i < m->order.count; i++)
        if (QC_AT(qcSortItem, m->order, i).key == same)
            UniteLink(m, QC_AT(qcSortItem, m->order, i));
    for (size_t i = 0; i < m->order.count; i++)
    {
        qcSortItem link = QC_AT(qcSortItem, m->order, i);
        if (qcSigned_Find(nodes, (uint32_t)(link.value >> 32)) >> 1 != qcSigned_Find(nodes, (uint32_t)link.value) >> 1)
            QC_AT(qcSortItem, m->order, stay++) = link;
    }
    m->order.count = stay;
}

/// Trees of pairs that are equal or opposite. The facts of a region in which nothing crosses are one from the start;
/// then come the sure links, and of the others those that still join something, the surest first.
static qcStatus GrowTrees(qcManifoldBuilder* m, const qcMeetingInput* input)
{
    QC_TRY(qcArray_Resize(&m->parts, m->work.count, sizeof(Part), "signs of normals"));
    for (size_t i = 0; i < m->freePairs.count; i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(m, i);
        QC_AT(uint32_t, m->nodes, p) = p << 1;
        const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        if (qcManifoldBuilder_PairRegion(m, pair)->unsettled)
            MakePart(&QC_AT(Part, m->parts, p), m, p, &input->proximities[pair->source]);
        else
            QC_AT(Part, m->parts, p).count = 0;
    }
    for (size_t i = 0; i < m->freePairs.count; i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(m, i);
        const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        const qcPairRegion* region = qcManifoldBuilder_PairRegion(m, pair);
        if (pair->apart && region->unsettled && !region->crossing)
            Join(m, region->fact, p, 0, false);
    }
    m->order.count = 0;
    for (size_t i = 0; i < m->freePairs.count; i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(m, i);
        if (i % qc_linkRoom == 0)
            QC_TRY(qcArray_Reserve(&m->order, m->order.count + 2 * qc_linkRoom * qc_maxRing, sizeof(qcSortItem),
                                   "signs of normals"));
        for (int side = 0; side < 2 && qcManifoldBuilder_PairRegion(m, qcManifoldBuilder_Pair(m, p))->unsettled; side++)
            TakeLinks(m, p, side);
    }
    DropLinks(m);
    QC_TRY(qcSort_Items(m->order.data, m->order.count, &m->scratch));
    for (size_t i = 0; i < m->order.count; i++)
        UniteLink(m, QC_AT(qcSortItem, m->order, i));
    return qc_statusOk;
}

static void Turn(qcManifoldPair* pair)
{
    pair->normal = qcNegated(pair->normal);
    pair->turned = !pair->turned;
}

/// Turns each pair so that it agrees with the first of its part; or with the facts of its region, if it hangs together
/// with them: such a part has no choice.
static void Agree(qcManifoldBuilder* m)
{
    uint32_t* nodes = m->nodes.data;
    for (size_t i = 0; i < m->freePairs.count; i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(m, i);
        qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        const qcPairRegion* region = qcManifoldBuilder_PairRegion(m, pair);
        if (!region->unsettled)
            continue;
        uint32_t root = qcSigned_Find(nodes, p), fact = UINT32_MAX;
        if (!region->crossing && region->fact != UINT32_MAX)
            fact = qcSigned_Find(nodes, region->fact);
        bool withFacts = fact >> 1 == root >> 1;
        if ((withFacts ? root ^ fact : root) & 1u)
            Turn(pair);
        if (withFacts)
            QC_AT(Part, m->parts, root >> 1).count = 0;
    }
}

/// A corner of a body's box, in the unit of this build.
static qcVector ScaledCorner(const qcManifoldBuilder* m, const double corner[3])
{
    if (m->exponent == 0)
        return qcVector_Load(corner);
    return (qcVector){ldexp(corner[0], -m->exponent), ldexp(corner[1], -m->exponent), ldexp(corner[2], -m->exponent)};
}

static qcVector CentreOf(const qcManifoldBuilder* m, const qcBody* body)
{
    qcVector lower = ScaledCorner(m, body->lower), upper = ScaledCorner(m, body->upper);
    return (qcVector){0.5 * lower.x + 0.5 * upper.x, 0.5 * lower.y + 0.5 * upper.y, 0.5 * lower.z + 0.5 * upper.z};
}

static double Size2(const qcManifoldBuilder* m, const qcBody* body)
{
    qcVector diagonal = qcMinus(ScaledCorner(m, body->upper), ScaledCorner(m, body->lower));
    return qcDot(diagonal, diagonal);
}

/// Above 0: the bodies lie on the sides that the normals name; below: on the other sides; 0: on neither clearly.
static double SideOfBodies(const qcManifoldBuilder* m, const Part* part, const qcManifoldPair* pair)
{
    double length = sqrt(qcDot(part->normal, part->normal));
    // Normals all around a body have no common side.
    const qcBody *bodyA = pair->side[0]->body, *bodyB = pair->side[1]->body;
    if (bodyA == bodyB || !(length > 0.5 * part->count))
        return 0.0;
    qcVector zero = {0.0, 0.0, 0.0};
    qcVector place = qcPlusScaled(zero, part->place, 1.0 / part->count);
    double a2 = Size2(m, bodyA), b2 = Size2(m, bodyB);
    double a = qcDot(qcMinus(CentreOf(m, bodyA), place), part->normal) / length;
    double b = qcDot(qcMinus(CentreOf(m, bodyB), place), part->normal) / length;
    double smaller2 = fmin(a2, b2);
    // Each as a share of the body's size, and the shares weighed by one over its square: less, and a ring on the floor
    // of a deep bin would be sent out through the floor, since the centre of the bin is far above.
    double side = (a2 > 0.0 ? a / (a2 * sqrt(a2)) : 0.0) - (b2 > 0.0 ? b / (b2 * sqrt(b2)) : 0.0);
    return fabs(side) * smaller2 > s_noSide ? side : 0.0;
}

static bool PointsDown(qcVector n)
{
    return n.x != 0.0 ? n.x < 0.0 : n.y != 0.0 ? n.y < 0.0 : n.z < 0.0;
}

static bool IsWrongWay(const qcManifoldBuilder* m, const Part* part, const qcManifoldPair* first, double margin)
{
    double shorter = fmin(part->along, part->against), longer = fmax(part->along, part->against);
    double rounding = QC_MANIFOLD_ROUNDING * part->size;
    if (shorter < (shorter <= margin + rounding ? s_shorter : s_muchShorter) * longer - rounding)
        return part->against < part->along;
    double bodies = SideOfBodies(m, part, first);
    if (bodies != 0.0)
        return bodies < 0.0;
    if (fabs(part->sumAlong - part->sumAgainst) > rounding * part->count)
        return part->sumAgainst < part->sumAlong;
    return PointsDown(first->normal);
}

qcStatus qcManifoldBuilder_ChooseSigns(qcManifoldBuilder* m, const qcMeetingInput* input)
{
    if (!FindFacts(m))
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&m->nodes, m->work.count, sizeof(uint32_t), "signs of normals"));
    QC_TRY(GrowTrees(m, input));
    Agree(m);
    for (size_t i = 0; i < m->freePairs.count; i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(m, i);
        Part* part = &QC_AT(Part, m->parts, p);
        part->wrongWay = part->count != 0 && IsWrongWay(m, part, qcManifoldBuilder_Pair(m, p), input->margin);
    }
    for (size_t i = 0; i < m->freePairs.count; i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(m, i);
        if (QC_AT(Part, m->parts, qcSigned_Find(m->nodes.data, p) >> 1).wrongWay)
            Turn(qcManifoldBuilder_Pair(m, p));
    }
    return qc_statusOk;
}
