// Gathers the pairs of two bodies and their triangles: each triangle once, with its corners in world space and its
// vertices welded. Vertices are the same if their positions are, bit for bit: this connects soups without shared
// indices, and both sides of a texture seam.
#include "manifold/topology.h"
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

/// The number of a body's vertex among those of the triangles; adds it if it is new.
static uint32_t AddVertex(const Side* side, uint32_t index, qcContactTopology* topology)
{
    uint32_t* number = &QC_AT(uint32_t, topology->vertexNumbers, side->firstVertex + index);
    if (*number == 0)
    {
        qcManifoldVertex* vertex = &QC_AT(qcManifoldVertex, topology->vertices, topology->vertices.count++);
        double p[3];
        qcBody_GetVertex(side->body, index, p);
        *vertex = (qcManifoldVertex){side->slot, side->firstVertex + index, qcVector_Load(p)};
        *number = (uint32_t)topology->vertices.count;
    }
    return *number - 1;
}

/// The first vertex of the same body at the same position.
static uint32_t Weld(qcContactTopology* topology, uint32_t number)
{
    const qcManifoldVertex* vertex = &QC_AT(qcManifoldVertex, topology->vertices, number);
    size_t mask = topology->hashTable.count - 1;
    for (size_t i = Hash(vertex) & mask;; i = (i + 1) & mask)
    {
        uint32_t* entry = &QC_AT(uint32_t, topology->hashTable, i);
        if (*entry == 0)
        {
            *entry = number + 1;
            return number;
        }
        const qcManifoldVertex* other = &QC_AT(qcManifoldVertex, topology->vertices, *entry - 1);
        if (other->slot == vertex->slot && other->position.x == vertex->position.x &&
            other->position.y == vertex->position.y && other->position.z == vertex->position.z)
            return *entry - 1;
    }
}

/// At least half of the hash table is empty.
static qcStatus WeldVertices(qcContactTopology* topology)
{
    size_t size = 16, count = topology->vertices.count;
    while (size < 2 * count)
        size *= 2;
    QC_TRY(qcArray_Resize(&topology->hashTable, size, sizeof(uint32_t), "vertices of manifolds"));
    memset(topology->hashTable.data, 0, size * sizeof(uint32_t));
    QC_TRY(qcArray_Resize(&topology->welded, count, sizeof(uint32_t), "vertices of manifolds"));
    for (uint32_t v = 0; v < count; v++)
        QC_AT(uint32_t, topology->welded, v) = Weld(topology, v);
    return qc_statusOk;
}

/// The later stages multiply up to four lengths. Coordinates beyond 2^±64 are scaled by a power of two, so that the
/// products of all but the smallest triangles neither overflow nor underflow. Vertices have been welded: none is
/// rounded to another one.
static void ChooseUnit(qcContactTopology* topology)
{
    double largest = 0.0;
    for (size_t v = 0; v < topology->vertices.count; v++)
    {
        qcVector p = QC_AT(qcManifoldVertex, topology->vertices, v).position;
        double x = fabs(p.x), y = fabs(p.y), z = fabs(p.z), larger = x > y ? x : y;
        larger = z > larger ? z : larger;
        largest = larger > largest ? larger : largest;
    }
    topology->exponent = 0;
    if (largest == 0.0 || (largest >= 0x1p-64 && largest <= 0x1p64))
        return;
    topology->exponent = ilogb(largest);
    for (size_t v = 0; v < topology->vertices.count; v++)
    {
        qcVector* p = &QC_AT(qcManifoldVertex, topology->vertices, v).position;
        *p = (qcVector){ldexp(p->x, -topology->exponent), ldexp(p->y, -topology->exponent),
                        ldexp(p->z, -topology->exponent)};
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

static void SetNormal(qcManifoldTriangle* triangle)
{
    const qcVector* corner = triangle->corner;
    qcVector normal = qcCross(qcMinus(corner[1], corner[0]), qcMinus(corner[2], corner[0]));
    double length = sqrt(qcDot(normal, normal));
    triangle->doubleArea = length;
    triangle->normal = (qcVector){0.0, 0.0, 0.0};
    if (length > 0.0 && isfinite(length))
        triangle->normal = (qcVector){normal.x / length, normal.y / length, normal.z / length};
}

static size_t Min(size_t a, size_t b)
{
    return a < b ? a : b;
}

/// Makes room for all triangles that the pairs can have, and for their vertices.
static qcStatus EmptyTriangles(const Side sides[2], const qcBodyPairInput* input, qcContactTopology* topology)
{
    const qcBody *a = sides[0].body, *b = sides[1].body;
    size_t triangles = sides[1].firstTriangle + (size_t)b->triangleCount;
    size_t vertices = sides[1].firstVertex + b->vertexCount;
    QC_TRY(qcArray_GrowZeroed(&topology->triangleNumbers, triangles, sizeof(uint32_t), "triangles of manifolds"));
    QC_TRY(qcArray_GrowZeroed(&topology->vertexNumbers, vertices, sizeof(uint32_t), "vertices of manifolds"));
    size_t bound = Min(input->runCount, a->triangleCount) + Min(input->pairCount, b->triangleCount);
    QC_TRY(qcArray_Reserve(&topology->triangles, bound, sizeof(qcManifoldTriangle), "triangles of manifolds"));
    QC_TRY(qcArray_Reserve(&topology->vertices, Min(3 * bound, vertices), sizeof(qcManifoldVertex),
                           "vertices of manifolds"));
    topology->triangles.count = topology->vertices.count = 0;
    return qc_statusOk;
}

static void AddTriangle(const Side* side, uint32_t index, qcContactTopology* topology)
{
    uint32_t* number = &QC_AT(uint32_t, topology->triangleNumbers, side->firstTriangle + index);
    if (*number != 0)
        return;
    qcManifoldTriangle* triangle = &QC_AT(qcManifoldTriangle, topology->triangles, topology->triangles.count++);
    *number = (uint32_t)topology->triangles.count;
    // FinishTriangles fills the rest.
    triangle->body = side->body;
    triangle->slot = side->slot;
    triangle->index = index;
    triangle->pairCount = 0;
    for (unsigned c = 0; c < 3; c++)
    {
        triangle->bodyVertex[c] = side->body->indices[3 * (size_t)index + c];
        triangle->vertex[c] = AddVertex(side, triangle->bodyVertex[c], topology);
    }
}

/// The pairs of a run are reported[first..end).
static size_t RunOf(const qcBodyPairInput* input, uint32_t run, size_t* end)
{
    size_t first = (size_t)(input->runs[run].value >> 32);
    *end = first + (uint32_t)input->runs[run].value;
    return first;
}

/// Adds each triangle once, in the order of the pairs.
static void AddTriangles(const Side sides[2], const qcBodyPairInput* input, qcContactTopology* topology)
{
    for (uint32_t r = 0; r < input->runCount; r++)
    {
        size_t end, first = RunOf(input, r, &end);
        AddTriangle(&sides[0], input->reported->pairs[first].triangleA, topology);
        for (size_t i = first; i < end; i++)
            AddTriangle(&sides[1], input->reported->pairs[i].triangleB, topology);
    }
}

/// Fills the fields of triangles that depend on welded vertices and on the unit of length.
static void FinishTriangles(qcContactTopology* topology)
{
    for (size_t i = 0; i < topology->triangles.count; i++)
    {
        qcManifoldTriangle* triangle = &QC_AT(qcManifoldTriangle, topology->triangles, i);
        double(*lanes)[6] = triangle->cornerLanes;
        for (int c = 0; c < 3; c++)
        {
            triangle->vertex[c] = QC_AT(uint32_t, topology->welded, triangle->vertex[c]);
            triangle->corner[c] = QC_AT(qcManifoldVertex, topology->vertices, triangle->vertex[c]).position;
            lanes[0][c] = lanes[0][c + 3] = triangle->corner[c].x;
            lanes[1][c] = lanes[1][c + 3] = triangle->corner[c].y;
            lanes[2][c] = lanes[2][c + 3] = triangle->corner[c].z;
        }
        triangle->longestEdge = LongestEdge(triangle->corner);
        SetNormal(triangle);
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

static qcManifoldTriangle* TriangleAt(const Side* side, uint32_t index, qcContactTopology* topology)
{
    uint32_t number = QC_AT(uint32_t, topology->triangleNumbers, side->firstTriangle + index) - 1;
    return &QC_AT(qcManifoldTriangle, topology->triangles, number);
}

static void AddPair(const Side sides[2], const qcBodyPairInput* input, size_t i, qcContactTopology* topology)
{
    const qcPair* reported = &input->reported->pairs[i];
    qcManifoldTriangle* a = TriangleAt(&sides[0], reported->triangleA, topology);
    qcManifoldTriangle* b = TriangleAt(&sides[1], reported->triangleB, topology);
    // Triangles of one body that share a welded vertex touch because they are connected: no contact.
    if (reported->relation == qc_relationTouching && reported->bodyA == reported->bodyB && ShareVertex(a, b))
        return;
    a->pairCount++;
    b->pairCount++;
    bool hasProximity = input->reported->proximities != NULL && topology->exponent == 0;
    size_t number = topology->pairs.count++;
    QC_AT(qcManifoldPair, topology->pairs, number) =
        (qcManifoldPair){.side = {a, b},
                         .source = (uint32_t)(hasProximity ? i : number),
                         .relation = reported->relation,
                         .intersecting = reported->relation != qc_relationNear};
}

static void AddPairs(const Side sides[2], const qcBodyPairInput* input, qcContactTopology* topology)
{
    topology->pairs.count = 0;
    for (uint32_t r = 0; r < input->runCount; r++)
    {
        size_t end, first = RunOf(input, r, &end);
        for (size_t i = first; i < end; i++)
            AddPair(sides, input, i, topology);
    }
}

static void ClearNumbers(const Side sides[2], qcContactTopology* topology)
{
    for (size_t i = 0; i < topology->triangles.count; i++)
    {
        const qcManifoldTriangle* triangle = &QC_AT(qcManifoldTriangle, topology->triangles, i);
        const Side* side = &sides[triangle->body == sides[0].body ? 0 : 1];
        QC_AT(uint32_t, topology->triangleNumbers, side->firstTriangle + triangle->index) = 0;
    }
    for (size_t v = 0; v < topology->vertices.count; v++)
        QC_AT(uint32_t, topology->vertexNumbers, QC_AT(qcManifoldVertex, topology->vertices, v).index) = 0;
}

/// Lists the pairs of each triangle, in their order.
static qcStatus ListPairs(qcContactTopology* topology)
{
    size_t count = topology->pairs.count;
    QC_TRY(qcArray_Resize(&topology->pairsOf, 2 * count, sizeof(qcPairEntry), "pairs of manifolds"));
    uint32_t first = 0;
    qcManifoldTriangle* triangles = topology->triangles.data;
    for (size_t i = 0; i < topology->triangles.count; i++)
    {
        triangles[i].firstPair = first;
        first += triangles[i].pairCount;
        triangles[i].pairCount = 0;
    }
    for (uint32_t p = 0; p < count; p++)
        for (uint32_t side = 0; side < 2; side++)
        {
            const qcManifoldPair* pair = qcContactTopology_Pair(topology, p);
            qcManifoldTriangle* triangle = &triangles[qcContactTopology_TriangleOf(topology, pair->side[side])];
            QC_AT(qcPairEntry, topology->pairsOf, triangle->firstPair + triangle->pairCount++) = (qcPairEntry){p, side};
        }
    return qc_statusOk;
}

static void SetSides(const qcStepTriangles* triangles, const qcBodyPairInput* input, Side sides[2])
{
    uint64_t bodies = input->runs[0].key;
    const uint32_t slots[2] = {(uint32_t)(bodies >> 32), (uint32_t)bodies};
    for (int side = 0; side < 2; side++)
        sides[side] = (Side){.body = &QC_AT(qcBody, triangles->bodies->slots, slots[side]), .slot = slots[side]};
    if (slots[0] == slots[1])
        return;
    sides[1].firstTriangle = sides[0].body->triangleCount;
    sides[1].firstVertex = sides[0].body->vertexCount;
}

qcStatus qcContactTopology_Gather(const qcStepTriangles* triangles, const qcBodyPairInput* input,
                                  qcContactTopology* topology)
{
    Side sides[2];
    SetSides(triangles, input, sides);
    QC_TRY(qcArray_Reserve(&topology->pairs, input->pairCount, sizeof(qcManifoldPair), "pairs of manifolds"));
    QC_TRY(EmptyTriangles(sides, input, topology));
    AddTriangles(sides, input, topology);
    qcStatus status = WeldVertices(topology);
    if (status == qc_statusOk)
    {
        ChooseUnit(topology);
        FinishTriangles(topology);
        AddPairs(sides, input, topology);
    }
    ClearNumbers(sides, topology);
    QC_TRY(status);
    return ListPairs(topology);
}

void qcContactTopology_Free(qcContactTopology* topology)
{
    qcArray* arrays[] = {&topology->pairs,           &topology->triangles,     &topology->vertices,  &topology->pairsOf,
                         &topology->triangleNumbers, &topology->vertexNumbers, &topology->hashTable, &topology->welded,
                         &topology->nodes,           &topology->lastEntry};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
