// The reported pairs with what the manifold stage asks of them, and their triangles: each once, however many pairs it
// is in, with its corners in world space and its vertices welded.
//
// Vertices are the same if their positions are, bit for bit: soups without shared indices and seams of texture
// coordinates are as connected as they look.
#include "manifold/manifold_builder.h"
#include "base/point_hash.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

/// A body, and where its triangles and vertices begin among those of both.
typedef struct Side
{
    const qcBody* body;
    uint32_t slot, firstTriangle;
    size_t firstVertex;
} Side;

//  ---- vertices -------------------------------------------------------------------------------------------

static uint64_t Hash(const qcManifoldVertex* vertex)
{
    return qcPointHash_Of(vertex->slot, vertex->position.x, vertex->position.y, vertex->position.z);
}

/// The number of a vertex of a body among those of the triangles.
static uint32_t TakeVertex(qcManifoldBuilder* m, const Side* side, uint32_t index)
{
    uint32_t* number = &QC_AT(uint32_t, m->vertexNumbers, side->firstVertex + index);
    if (*number == 0)
    {
        qcManifoldVertex* vertex = &QC_AT(qcManifoldVertex, m->vertices, m->vertices.count++);
        double p[3];
        qcBody_GetVertex(side->body, index, p);
        *vertex = (qcManifoldVertex){side->slot, side->firstVertex + index, qcVector_Load(p)};
        *number = (uint32_t)m->vertices.count;
    }
    return *number - 1;
}

/// The first vertex of the same body at the same place.
static uint32_t Weld(qcManifoldBuilder* m, uint32_t number)
{
    const qcManifoldVertex* vertex = &QC_AT(qcManifoldVertex, m->vertices, number);
    size_t mask = m->table.count - 1;
    for (size_t place = Hash(vertex) & mask;; place = (place + 1) & mask)
    {
        uint32_t* entry = &QC_AT(uint32_t, m->table, place);
        if (*entry == 0)
        {
            *entry = number + 1;
            return number;
        }
        const qcManifoldVertex* other = &QC_AT(qcManifoldVertex, m->vertices, *entry - 1);
        if (other->slot == vertex->slot && other->position.x == vertex->position.x &&
            other->position.y == vertex->position.y && other->position.z == vertex->position.z)
            return *entry - 1;
    }
}

/// Of all vertices, into m->nodes. The table is half empty at least.
static qcStatus WeldVertices(qcManifoldBuilder* m)
{
    size_t size = 16;
    while (size < 2 * m->vertices.count)
        size *= 2;
    QC_TRY(qcArray_Resize(&m->table, size, sizeof(uint32_t), "vertices of manifolds"));
    memset(m->table.data, 0, size * sizeof(uint32_t));
    QC_TRY(qcArray_Resize(&m->nodes, m->vertices.count, sizeof(uint32_t), "vertices of manifolds"));
    for (uint32_t v = 0; v < m->vertices.count; v++)
        QC_AT(uint32_t, m->nodes, v) = Weld(m, v);
    return qc_statusOk;
}

/// The stage multiplies up to four lengths. Coordinates beyond 2^±64 are scaled by a power of two, so that products
/// of all but the smallest triangles neither overflow nor underflow. Vertices are welded before: none is rounded to
/// another one.
static void ChooseUnit(qcManifoldBuilder* m, qcMeetingInput* input)
{
    double largest = 0.0;
    for (size_t v = 0; v < m->vertices.count; v++)
    {
        qcVector p = QC_AT(qcManifoldVertex, m->vertices, v).position;
        double x = fabs(p.x), y = fabs(p.y), z = fabs(p.z), larger = x > y ? x : y;
        larger = z > larger ? z : larger;
        largest = larger > largest ? larger : largest;
    }
    m->exponent = 0;
    if (largest == 0.0 || (largest >= 0x1p-64 && largest <= 0x1p64))
        return;
    m->exponent = ilogb(largest);
    for (size_t v = 0; v < m->vertices.count; v++)
    {
        qcVector* p = &QC_AT(qcManifoldVertex, m->vertices, v).position;
        *p = (qcVector){ldexp(p->x, -m->exponent), ldexp(p->y, -m->exponent), ldexp(p->z, -m->exponent)};
    }
    input->margin = ldexp(input->margin, -m->exponent);
    input->proximities = NULL;
    input->feet = NULL;
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

static void FindNormal(qcManifoldTriangle* triangle)
{
    const qcVector* corner = triangle->corner;
    qcVector normal = qcCross(qcMinus(corner[1], corner[0]), qcMinus(corner[2], corner[0]));
    double length = sqrt(qcDot(normal, normal));
    triangle->doubleArea = length;
    triangle->normal = (qcVector){0.0, 0.0, 0.0};
    if (length > 0.0 && isfinite(length))
        triangle->normal = (qcVector){normal.x / length, normal.y / length, normal.z / length};
}

static size_t Lesser(size_t a, size_t b)
{
    return a < b ? a : b;
}

/// Room for all triangles that the pairs can name, and for their vertices.
static qcStatus EmptyTriangles(qcManifoldBuilder* m, const Side sides[2], const qcMeetingInput* input)
{
    const qcBody *a = sides[0].body, *b = sides[1].body;
    size_t triangles = sides[1].firstTriangle + (size_t)b->triangleCount;
    size_t vertices = sides[1].firstVertex + b->vertexCount;
    QC_TRY(qcArray_GrowZeroed(&m->numbers, triangles, sizeof(uint32_t), "triangles of manifolds"));
    QC_TRY(qcArray_GrowZeroed(&m->vertexNumbers, vertices, sizeof(uint32_t), "vertices of manifolds"));
    size_t bound = Lesser(input->runCount, a->triangleCount) + Lesser(input->count, b->triangleCount);
    QC_TRY(qcArray_Reserve(&m->triangles, bound, sizeof(qcManifoldTriangle), "triangles of manifolds"));
    QC_TRY(
        qcArray_Reserve(&m->vertices, Lesser(3 * bound, vertices), sizeof(qcManifoldVertex), "vertices of manifolds"));
    m->triangles.count = m->vertices.count = 0;
    return qc_statusOk;
}

static void TakeTriangle(qcManifoldBuilder* m, const Side* side, uint32_t index)
{
    uint32_t* number = &QC_AT(uint32_t, m->numbers, side->firstTriangle + index);
    if (*number != 0)
        return;
    qcManifoldTriangle* triangle = &QC_AT(qcManifoldTriangle, m->triangles, m->triangles.count++);
    *number = (uint32_t)m->triangles.count;
    // The rest is filled where it is known.
    triangle->body = side->body;
    triangle->slot = side->slot;
    triangle->index = index;
    triangle->pairCount = 0;
    for (unsigned c = 0; c < 3; c++)
    {
        triangle->name[c] = side->body->indices[3 * (size_t)index + c];
        triangle->vertex[c] = TakeVertex(m, side, triangle->name[c]);
    }
}

//  ---- pairs ----------------------------------------------------------------------------------------------

static bool ShareVertex(const qcManifoldTriangle* a, const qcManifoldTriangle* b)
{
    for (int i = 0; i < 9; i++)
        if (a->vertex[i / 3] == b->vertex[i % 3])
            return true;
    return false;
}

static qcManifoldTriangle* TriangleOf(const qcManifoldBuilder* m, const Side* side, uint32_t index)
{
    return &QC_AT(qcManifoldTriangle, m->triangles, QC_AT(uint32_t, m->numbers, side->firstTriangle + index) - 1);
}

/// Each once, in the order of the pairs.
static void TakeTriangles(qcManifoldBuilder* m, const Side sides[2], const qcMeetingInput* input)
{
    for (uint32_t r = 0; r < input->runCount; r++)
    {
        size_t first = (size_t)(input->runs[r].value >> 32), end = first + (uint32_t)input->runs[r].value;
        TakeTriangle(m, &sides[0], input->reported->pairs[first].triangleA);
        for (size_t i = first; i < end; i++)
            TakeTriangle(m, &sides[1], input->reported->pairs[i].triangleB);
    }
}

/// What is known of them once their vertices are welded.
static void FinishTriangles(qcManifoldBuilder* m)
{
    for (size_t i = 0; i < m->triangles.count; i++)
    {
        qcManifoldTriangle* triangle = &QC_AT(qcManifoldTriangle, m->triangles, i);
        for (int c = 0; c < 3; c++)
        {
            triangle->vertex[c] = QC_AT(uint32_t, m->nodes, triangle->vertex[c]);
            triangle->corner[c] = QC_AT(qcManifoldVertex, m->vertices, triangle->vertex[c]).position;
            triangle->around[0][c] = triangle->around[0][c + 3] = triangle->corner[c].x;
            triangle->around[1][c] = triangle->around[1][c + 3] = triangle->corner[c].y;
            triangle->around[2][c] = triangle->around[2][c + 3] = triangle->corner[c].z;
        }
        triangle->longestEdge = LongestEdge(triangle->corner);
        FindNormal(triangle);
    }
}

static void TakePair(qcManifoldBuilder* m, const Side sides[2], const qcMeetingInput* input, size_t i)
{
    const qcPair* pair = &input->reported->pairs[i];
    qcManifoldTriangle* a = TriangleOf(m, &sides[0], pair->triangleA);
    qcManifoldTriangle* b = TriangleOf(m, &sides[1], pair->triangleB);
    // A seam, or neighbours that were asked for: that they hang together is no contact.
    if (pair->relation == qc_relationTouching && pair->bodyA == pair->bodyB && ShareVertex(a, b))
        return;
    a->pairCount++;
    b->pairCount++;
    // Field by field: clearing all of it takes longer than all else here. The rest is filled where it is known.
    qcManifoldPair* taken = &QC_AT(qcManifoldPair, m->work, m->work.count);
    taken->side[0] = a;
    taken->side[1] = b;
    taken->gap = 0.0;
    taken->source = (uint32_t)(input->proximities != NULL ? i : m->work.count);
    taken->relation = pair->relation;
    taken->meets = pair->relation != qc_relationNear;
    taken->settled = taken->swapped = taken->own = taken->turned = taken->apart = false;
    taken->parted = taken->surpassed = taken->crossing = false;
    m->work.count++;
}

static void TakePairs(qcManifoldBuilder* m, const Side sides[2], const qcMeetingInput* input)
{
    m->work.count = 0;
    for (uint32_t r = 0; r < input->runCount; r++)
    {
        size_t first = (size_t)(input->runs[r].value >> 32), end = first + (uint32_t)input->runs[r].value;
        for (size_t i = first; i < end; i++)
            TakePair(m, sides, input, i);
    }
}

static void ClearNumbers(qcManifoldBuilder* m, const Side sides[2])
{
    for (size_t i = 0; i < m->triangles.count; i++)
    {
        const qcManifoldTriangle* triangle = &QC_AT(qcManifoldTriangle, m->triangles, i);
        const Side* side = &sides[triangle->body == sides[0].body ? 0 : 1];
        QC_AT(uint32_t, m->numbers, side->firstTriangle + triangle->index) = 0;
    }
    for (size_t v = 0; v < m->vertices.count; v++)
        QC_AT(uint32_t, m->vertexNumbers, QC_AT(qcManifoldVertex, m->vertices, v).place) = 0;
}

/// Lists the pairs of each triangle, in their order.
static qcStatus ListPairs(qcManifoldBuilder* m)
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
            qcManifoldTriangle* triangle = qcManifoldBuilder_Triangle(m, qcManifoldBuilder_Pair(m, p), side);
            QC_AT(qcPairSide, m->pairsOf, triangle->firstPair + triangle->pairCount++) = (qcPairSide){p, side};
        }
    return qc_statusOk;
}

static void SetSides(const qcStepTriangles* t, const qcMeetingInput* input, Side sides[2])
{
    uint64_t bodies = input->runs[0].key;
    const uint32_t slots[2] = {(uint32_t)(bodies >> 32), (uint32_t)bodies};
    for (int side = 0; side < 2; side++)
        sides[side] = (Side){.body = &QC_AT(qcBody, t->bodies->slots, slots[side]), .slot = slots[side]};
    if (slots[0] == slots[1])
        return;
    sides[1].firstTriangle = sides[0].body->triangleCount;
    sides[1].firstVertex = sides[0].body->vertexCount;
}

qcStatus qcManifoldBuilder_TakePairs(qcManifoldBuilder* m, const qcStepTriangles* t, qcMeetingInput* input)
{
    Side sides[2];
    SetSides(t, input, sides);
    QC_TRY(qcArray_Reserve(&m->work, input->count, sizeof(qcManifoldPair), "pairs of manifolds"));
    QC_TRY(EmptyTriangles(m, sides, input));
    TakeTriangles(m, sides, input);
    qcStatus status = WeldVertices(m);
    if (status == qc_statusOk)
    {
        ChooseUnit(m, input);
        FinishTriangles(m);
        TakePairs(m, sides, input);
    }
    ClearNumbers(m, sides);
    QC_TRY(status);
    return ListPairs(m);
}
