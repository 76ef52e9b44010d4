// Who lies beside whom, and the connected regions of contact. Adjacency by lists of a common key, sorted; regions by
// union-find (Galler, Fischer: An improved equivalence algorithm, 1964), each link with a sign.
//
// Two pairs are neighbours if one of their triangles is the same and the other two share a vertex: one foot stays, the
// other takes a step. Asking for the step on one side only keeps two sides of one sheet apart: a sheet in a slit
// touches both walls with the same triangles, but the walls are not beside each other, and what they say of the sheet
// may well be opposite. Vertices are the same if their positions are, bit for bit: soups without shared indices and
// seams of texture coordinates are as connected as they look.
//
// A body with itself has no A and B: which of two triangles has the lower index is an accident, and the normal from
// the one to the other would flip with it. A region names its sides once: a neighbour that has the common triangle on
// the other side is turned around.
#include "manifold_parts.h"
#include "sort.h"
#include "status.h"

#include <math.h>
#include <string.h>

qcWaysOut qcManifoldPair_WaysOut(const qcManifoldPair* pair, qcVector direction)
{
    qcVector corner[2][3];
    qcManifoldPair_GetCorners(pair, 0, corner[0]);
    qcManifoldPair_GetCorners(pair, 1, corner[1]);
    double lower[2], upper[2];
    // Seen from a corner: far from the origin of the world the products would round away what lies between.
    qcVector origin = corner[1][0];
    for (int side = 0; side < 2; side++)
    {
        double x = qcDot(qcMinus(corner[side][0], origin), direction);
        double y = qcDot(qcMinus(corner[side][1], origin), direction);
        double z = qcDot(qcMinus(corner[side][2], origin), direction);
        double low = x < y ? x : y, high = x < y ? y : x;
        lower[side] = z < low ? z : low;
        upper[side] = z > high ? z : high;
    }
    return (qcWaysOut){upper[1] - lower[0], upper[0] - lower[1]};
}

double qcManifoldPair_LongestEdge(const qcManifoldPair* pair, int side)
{
    qcVector corner[3];
    qcManifoldPair_GetCorners(pair, side, corner);
    double longest2 = 0.0;
    for (int e = 0; e < 3; e++)
    {
        qcVector edge = qcMinus(corner[(e + 1) % 3], corner[e]);
        longest2 = fmax(longest2, qcDot(edge, edge));
    }
    return sqrt(longest2);
}

static qcVector UnitOrUp(const double normal[3])
{
    qcVector n = qcVector_Load(normal);
    double length2 = qcDot(n, n);
    return length2 > 0.5 && length2 < 2.0 ? n : (qcVector){0.0, 0.0, 1.0};
}

static bool ShareCorner(const qcManifoldPair* pair)
{
    qcVector corner[2][3];
    qcManifoldPair_GetCorners(pair, 0, corner[0]);
    qcManifoldPair_GetCorners(pair, 1, corner[1]);
    for (int i = 0; i < 9; i++)
    {
        qcVector p = corner[0][i / 3], q = corner[1][i % 3];
        if (p.x == q.x && p.y == q.y && p.z == q.z)
            return true;
    }
    return false;
}

static qcStatus TakePairs(qcManifolds* m, const qcTriangles* t, const qcPair* pairs, const qcProximity* proximities,
                          size_t count)
{
    QC_TRY(qcArray_Reserve(&m->work, count, sizeof(qcManifoldPair), "pairs of manifolds"));
    m->work.count = 0;
    for (size_t i = 0; i < count; i++)
    {
        const qcPair* pair = &pairs[i];
        const qcProximity* proximity = &proximities[i];
        qcManifoldPair work = {
            .body = {&QC_AT(qcBody, t->bodies->slots, pair->bodyA), &QC_AT(qcBody, t->bodies->slots, pair->bodyB)},
            .slot = {pair->bodyA, pair->bodyB},
            .triangle = {pair->triangleA, pair->triangleB},
            .normal = UnitOrUp(proximity->normal),
            .gap = proximity->distance - proximity->depth,
            .source = (uint32_t)i,
            .own = true,
            .crossing = pair->relation == qc_relationPenetrating && proximity->depth > 0.0};
        work.reported = work.normal;
        // A seam, or neighbours that were asked for: that they hang together is no contact.
        if (pair->relation == qc_relationTouching && pair->bodyA == pair->bodyB && ShareCorner(&work))
            continue;
        qcWaysOut ways = qcManifoldPair_WaysOut(&work, work.normal);
        double rounding = QC_MANIFOLD_ROUNDING * (ways.along + ways.against);
        work.apart = work.parted = pair->relation == qc_relationNear && ways.along < -rounding;
        QC_AT(qcManifoldPair, m->work, m->work.count++) = work;
    }
    return qc_statusOk;
}

//  ---- vertices -------------------------------------------------------------------------------------------

static uint64_t Mix(uint64_t hash, uint64_t bits)
{
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15ULL;
    return hash ^ hash >> 32;
}

static uint64_t Hash(uint32_t slot, const double* position)
{
    uint64_t hash = slot;
    for (int axis = 0; axis < 3; axis++)
    {
        double x = position[axis] + 0.0; // -0 becomes +0, which compares equal
        uint64_t bits;
        memcpy(&bits, &x, sizeof bits);
        hash = Mix(hash, bits);
    }
    return hash;
}

/// Room for every vertex that the pairs can name; half empty at least.
static qcStatus EmptyTable(qcManifolds* m, const qcTriangles* t, size_t pairCount)
{
    uint64_t bound = 0, size = 16;
    for (uint32_t body = 0; body < t->bodyCount; body++)
        bound += qcTriangles_Body(t, body)->vertexCount;
    bound = bound < 6 * (uint64_t)pairCount ? bound : 6 * (uint64_t)pairCount;
    while (size < 2 * bound)
        size *= 2;
    QC_TRY(qcArray_Resize(&m->table, size, sizeof(uint32_t), "vertices of manifolds"));
    memset(m->table.data, 0, size * sizeof(uint32_t));
    QC_TRY(qcArray_Reserve(&m->vertices, bound, sizeof(qcManifoldVertex), "vertices of manifolds"));
    m->vertices.count = 0;
    return qc_statusOk;
}

/// The number of a vertex of a body among those at different positions.
static uint32_t Weld(qcManifolds* m, const qcBody* body, uint32_t slot, uint32_t index)
{
    double p[3];
    qcBody_GetVertex(body, index, p);
    size_t mask = m->table.count - 1;
    for (size_t place = Hash(slot, p) & mask;; place = (place + 1) & mask)
    {
        uint32_t* entry = &QC_AT(uint32_t, m->table, place);
        if (*entry == 0)
        {
            QC_AT(qcManifoldVertex, m->vertices, m->vertices.count++) = (qcManifoldVertex){slot, qcVector_Load(p)};
            *entry = (uint32_t)m->vertices.count;
            return *entry - 1;
        }
        const qcManifoldVertex* other = &QC_AT(qcManifoldVertex, m->vertices, *entry - 1);
        if (other->slot == slot && p[0] == other->position.x && p[1] == other->position.y && p[2] == other->position.z)
            return *entry - 1;
    }
}

//  ---- pairs by key ---------------------------------------------------------------------------------------

/// Key: a triangle of the pair and a corner of its other triangle, three with A's triangle, then three with B's.
static qcStatus ListByKey(qcManifolds* m, const qcTriangles* t)
{
    size_t count = m->work.count * qc_besideKeys;
    QC_TRY(qcArray_Resize(&m->items, count, sizeof(qcSortItem), "neighbours in manifolds"));
    QC_TRY(qcArray_Resize(&m->at, count, sizeof(uint32_t), "neighbours in manifolds"));
    QC_TRY(EmptyTable(m, t, m->work.count));
    // Bodies by slot, for the ranks of their triangles.
    QC_TRY(qcArray_Resize(&m->nodes, t->bodies->slots.count, sizeof(uint32_t), "neighbours in manifolds"));
    for (uint32_t body = 0; body < t->bodyCount; body++)
        QC_AT(uint32_t, m->nodes, qcTriangles_Slot(t, body)) = qcTriangles_First(t, body);
    qcSortItem* item = m->items.data;
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        qcManifoldPair* pair = qcManifolds_Pair(m, p);
        for (int c = 0; c < 6; c++)
            pair->vertex[c / 3][c % 3] =
                Weld(m, pair->body[c / 3], pair->slot[c / 3], qcManifoldPair_Vertex(pair, c / 3, c % 3));
        pair->vertices = m->vertices.data; // there is room for all: they stay where they are
        for (int k = 0; k < qc_besideKeys; k++, item++)
        {
            int side = k / 3;
            uint64_t rank = (uint64_t)QC_AT(uint32_t, m->nodes, pair->slot[side]) + pair->triangle[side];
            *item = (qcSortItem){rank << 32 | pair->vertex[1 - side][k % 3], (uint64_t)p * qc_besideKeys + (unsigned)k};
        }
    }
    QC_TRY(qcSort_Items(m->items.data, count, &m->scratch));
    for (uint32_t place = 0; place < count; place++)
        QC_AT(uint32_t, m->at, QC_AT(qcSortItem, m->items, place).value) = place;
    return qc_statusOk;
}

/// Keys that a pair has in common with another one at a key; 0 if an earlier key has them too, so that the other pair
/// is met once.
static uint32_t CountShared(const qcManifoldPair* pair, unsigned k, const qcManifoldPair* other)
{
    const uint32_t* vertex = pair->vertex[1 - k / 3];
    const uint32_t* others = other->vertex[other->triangle[k / 3] == pair->triangle[k / 3] ? 1 - k / 3 : k / 3];
    uint32_t shared = 0;
    for (unsigned c = 0; c < 3; c++)
    {
        bool common = vertex[c] == others[0] || vertex[c] == others[1] || vertex[c] == others[2];
        if (common && c < k % 3)
            return 0;
        shared += common;
    }
    return shared;
}

uint32_t qcManifolds_CollectRing(const qcManifolds* m, uint32_t pair, qcBeside ring[qc_maxRing])
{
    const qcSortItem* items = m->items.data;
    const qcManifoldPair* self = qcManifolds_Pair(m, pair);
    uint32_t count = 0;
    for (unsigned k = 0; k < qc_besideKeys; k++)
    {
        // The report's A has the first three keys.
        unsigned mine = self->swapped ? (k + 3) % qc_besideKeys : k;
        size_t place = QC_AT(uint32_t, m->at, (size_t)pair * qc_besideKeys + mine);
        uint64_t key = items[place].key;
        size_t first = place < qc_besideReach ? 0 : place - qc_besideReach;
        size_t last = place + qc_besideReach < m->items.count ? place + qc_besideReach : m->items.count - 1;
        while (first < place && items[first].key != key)
            first++;
        for (size_t i = first; i <= last && items[i].key == key; i++)
        {
            uint32_t other = (uint32_t)(items[i].value / qc_besideKeys);
            uint32_t shared = other == pair ? 0 : CountShared(self, k, qcManifolds_Pair(m, other));
            if (shared != 0)
                ring[count++] = (qcBeside){other, shared};
        }
    }
    return count;
}

//  ---- regions --------------------------------------------------------------------------------------------

static void SwapSides(qcManifoldPair* pair)
{
    qcManifoldPair other = *pair;
    for (int side = 0; side < 2; side++)
    {
        pair->triangle[side] = other.triangle[1 - side];
        memcpy(pair->vertex[side], other.vertex[1 - side], sizeof pair->vertex[side]);
    }
    pair->normal = qcNegated(pair->normal);
    pair->reported = pair->normal;
    pair->swapped = true;
}

static qcStatus Join(qcManifolds* m)
{
    size_t count = m->work.count;
    QC_TRY(qcArray_Resize(&m->nodes, count, sizeof(uint32_t), "regions of contact"));
    uint32_t* nodes = m->nodes.data;
    for (uint32_t p = 0; p < count; p++)
        nodes[p] = p << 1;
    const qcSortItem* items = m->items.data;
    for (size_t i = 1; i < m->items.count; i++)
    {
        if (items[i].key != items[i - 1].key)
            continue;
        uint64_t p = items[i - 1].value, q = items[i].value;
        bool turned = (p % qc_besideKeys < 3) != (q % qc_besideKeys < 3);
        qcSigned_Unite(nodes, (uint32_t)(p / qc_besideKeys), (uint32_t)(q / qc_besideKeys), turned);
    }
    for (uint32_t p = 0; p < count; p++)
    {
        uint32_t root = qcSigned_Find(nodes, p);
        qcManifolds_Pair(m, p)->region = root >> 1;
        if (root & 1u)
            SwapSides(qcManifolds_Pair(m, p));
    }
    return qc_statusOk;
}

qcStatus qcManifolds_FindRegions(qcManifolds* m, const qcTriangles* t, const qcPair* pairs,
                                 const qcProximity* proximities, size_t count)
{
    QC_TRY(TakePairs(m, t, pairs, proximities, count));
    QC_TRY(ListByKey(m, t));
    return Join(m);
}
