// The reported pairs with what the manifold stage asks of them, and their triangles: each once, however many pairs it
// is in, with its corners in world space and its vertices welded.
//
// Vertices are the same if their positions are, bit for bit: soups without shared indices and seams of texture
// coordinates are as connected as they look.
#include "manifold_parts.h"
#include "status.h"

#include <math.h>
#include <string.h>

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

/// Room for `bound` vertices; half empty at least.
static qcStatus EmptyTable(qcManifolds* m, size_t bound)
{
    size_t size = 16;
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

//  ---- triangles ------------------------------------------------------------------------------------------

static double LongestEdge(const qcVector corner[3])
{
    double longest2 = 0.0;
    for (int e = 0; e < 3; e++)
    {
        qcVector edge = qcMinus(corner[(e + 1) % 3], corner[e]);
        longest2 = fmax(longest2, qcDot(edge, edge));
    }
    return sqrt(longest2);
}

static qcVector FaceNormal(const qcVector corner[3])
{
    qcVector normal = qcCross(qcMinus(corner[1], corner[0]), qcMinus(corner[2], corner[0]));
    double length = sqrt(qcDot(normal, normal));
    if (!(length > 0.0) || !isfinite(length))
        return (qcVector){0.0, 0.0, 0.0};
    return (qcVector){normal.x / length, normal.y / length, normal.z / length};
}

static void AddTriangle(qcManifolds* m, const qcBody* body, uint32_t slot, uint32_t index)
{
    qcManifoldTriangle triangle = {.body = body, .slot = slot, .index = index};
    for (int c = 0; c < 3; c++)
    {
        triangle.vertex[c] = Weld(m, body, slot, body->indices[3 * (size_t)index + (unsigned)c]);
        triangle.corner[c] = QC_AT(qcManifoldVertex, m->vertices, triangle.vertex[c]).position;
    }
    triangle.longestEdge = LongestEdge(triangle.corner);
    triangle.normal = FaceNormal(triangle.corner);
    QC_AT(qcManifoldTriangle, m->triangles, m->triangles.count++) = triangle;
}

/// Room for all triangles that the pairs can name, and for their vertices.
static qcStatus EmptyTriangles(qcManifolds* m, const qcTriangles* t, size_t pairCount)
{
    size_t bound = 2 * pairCount < t->count ? 2 * pairCount : t->count, known = m->numbers.count, vertices = 0;
    QC_TRY(qcArray_Reserve(&m->triangles, bound, sizeof(qcManifoldTriangle), "triangles of manifolds"));
    m->triangles.count = 0;
    if (known < t->count)
    {
        QC_TRY(qcArray_Resize(&m->numbers, t->count, sizeof(uint32_t), "triangles of manifolds"));
        memset(&QC_AT(uint32_t, m->numbers, known), 0, (t->count - known) * sizeof(uint32_t));
    }
    // Bodies by slot, for the ranks of their triangles.
    QC_TRY(qcArray_Resize(&m->nodes, t->bodies->slots.count, sizeof(uint32_t), "triangles of manifolds"));
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        QC_AT(uint32_t, m->nodes, qcTriangles_Slot(t, body)) = qcTriangles_First(t, body);
        vertices += qcTriangles_Body(t, body)->vertexCount;
    }
    return EmptyTable(m, vertices < 3 * bound ? vertices : 3 * bound);
}

static uint32_t* NumberOf(const qcManifolds* m, uint32_t slot, uint32_t triangle)
{
    return &QC_AT(uint32_t, m->numbers, QC_AT(uint32_t, m->nodes, slot) + triangle);
}

static qcManifoldTriangle* TakeTriangle(qcManifolds* m, const qcTriangles* t, uint32_t slot, uint32_t triangle)
{
    uint32_t* number = NumberOf(m, slot, triangle);
    if (*number == 0)
    {
        AddTriangle(m, &QC_AT(qcBody, t->bodies->slots, slot), slot, triangle);
        *number = (uint32_t)m->triangles.count;
    }
    return &QC_AT(qcManifoldTriangle, m->triangles, *number - 1);
}

//  ---- pairs ----------------------------------------------------------------------------------------------

static bool ShareVertex(const qcManifoldTriangle* a, const qcManifoldTriangle* b)
{
    for (int i = 0; i < 9; i++)
        if (a->vertex[i / 3] == b->vertex[i % 3])
            return true;
    return false;
}

static void TakePair(qcManifolds* m, const qcTriangles* t, const qcManifoldInput* input, size_t i)
{
    const qcPair* pair = &input->pairs[i];
    qcManifoldTriangle* a = TakeTriangle(m, t, pair->bodyA, pair->triangleA);
    qcManifoldTriangle* b = TakeTriangle(m, t, pair->bodyB, pair->triangleB);
    // A seam, or neighbours that were asked for: that they hang together is no contact.
    if (pair->relation == qc_relationTouching && pair->bodyA == pair->bodyB && ShareVertex(a, b))
        return;
    a->pairCount++;
    b->pairCount++;
    QC_AT(qcManifoldPair, m->work, m->work.count++) =
        (qcManifoldPair){.side = {a, b}, .source = (uint32_t)i, .meets = pair->relation != qc_relationNear};
}

/// Lists the pairs of each triangle, in their order.
static qcStatus ListPairs(qcManifolds* m)
{
    QC_TRY(qcArray_Resize(&m->pairsOf, 2 * m->work.count, sizeof(qcPairSide), "pairs of manifolds"));
    uint32_t first = 0;
    for (size_t i = 0; i < m->triangles.count; i++)
    {
        qcManifoldTriangle* triangle = &QC_AT(qcManifoldTriangle, m->triangles, i);
        triangle->firstPair = first;
        first += triangle->pairCount;
        triangle->pairCount = 0;
    }
    for (uint32_t p = 0; p < m->work.count; p++)
        for (uint32_t side = 0; side < 2; side++)
        {
            qcManifoldTriangle* triangle = qcManifolds_Triangle(m, qcManifolds_Pair(m, p), side);
            QC_AT(qcPairSide, m->pairsOf, triangle->firstPair + triangle->pairCount++) = (qcPairSide){p, side};
        }
    return qc_statusOk;
}

qcStatus qcManifolds_TakePairs(qcManifolds* m, const qcTriangles* t, const qcManifoldInput* input)
{
    QC_TRY(qcArray_Reserve(&m->work, input->count, sizeof(qcManifoldPair), "pairs of manifolds"));
    m->work.count = 0;
    QC_TRY(EmptyTriangles(m, t, input->count));
    for (size_t i = 0; i < input->count; i++)
        TakePair(m, t, input, i);
    for (size_t i = 0; i < m->triangles.count; i++)
    {
        const qcManifoldTriangle* triangle = &QC_AT(qcManifoldTriangle, m->triangles, i);
        *NumberOf(m, triangle->slot, triangle->index) = 0;
    }
    return ListPairs(m);
}
