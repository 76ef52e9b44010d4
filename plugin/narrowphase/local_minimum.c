// Local minima of distance: Johnson, Cohen: A Framework for Efficient Minimum Distance Computations, 1998; the normal
// cones of edges and vertices: Johnson, Willemsen: Six Degree-of-Freedom Haptic Rendering of Complex Polygonal Models,
// 2003. Proof: plugin/docs/proofs/local_minimum_filter.md.
#include "narrowphase/local_minimum.h"

#include "base/status.h"

// The angle between triangles, in radians, below which an edge is flat. It exceeds the error of a plane in single
// precision. A thousand such edges in a row bend a surface by 0.1 radians: it is off a plane by an 80th of its length.
static const double s_flat = 1e-4;

static qcVector LocalOf(const qcBody* body, uint32_t vertex)
{
    return qcVector_Load(body->local + 3 * (size_t)vertex);
}

static qcVector WorldOf(const qcBody* body, uint32_t vertex)
{
    double position[3];
    qcBody_GetVertex(body, vertex, position);
    return qcVector_Load(position);
}

static qcVector NormalOf(const qcBody* body, uint32_t triangle)
{
    const uint32_t* v = body->indices + 3 * (size_t)triangle;
    qcVector p = LocalOf(body, v[0]);
    return qcCross(qcMinus(LocalOf(body, v[1]), p), qcMinus(LocalOf(body, v[2]), p));
}

static uint32_t Across(const qcLocalMinima* localMinima, uint32_t triangle, int edge)
{
    return QC_AT(uint32_t, localMinima->adjacency.across, 3 * (size_t)triangle + (size_t)edge);
}

static bool IsFlatEdge(const qcLocalMinima* localMinima, const qcBody* body, uint32_t triangle, int edge)
{
    uint32_t other = Across(localMinima, triangle, edge);
    if (other == QC_NO_SLOT)
        return false;
    qcVector m = NormalOf(body, triangle), n = NormalOf(body, other), c = qcCross(m, n);
    return qcDot(m, n) > 0.0 && qcDot(c, c) <= s_flat * s_flat * qcDot(m, m) * qcDot(n, n);
}

/// Removes flat edges, and marks the vertices of all others.
static void DropFlatEdges(qcLocalMinima* localMinima, const qcBody* body, uint8_t* bends)
{
    for (uint32_t t = 0; t < body->triangleCount; t++)
    {
        const uint32_t* v = body->indices + 3 * (size_t)t;
        unsigned owned = body->owned[t];
        for (int e = 0; e < 3; e++)
            if (IsFlatEdge(localMinima, body, t, e))
                owned &= ~(8u << e);
            else
                bends[v[e]] = bends[v[(e + 1) % 3]] = 1;
        QC_AT(qcOwnedFeatures, localMinima->owned, t) = (qcOwnedFeatures)owned;
    }
}

static qcStatus Make(qcLocalMinima* localMinima, const qcBody* body)
{
    QC_TRY(
        qcArray_Resize(&localMinima->owned, body->triangleCount, sizeof(qcOwnedFeatures), "the local-minimum filter"));
    QC_TRY(qcAdjacency_Build(&localMinima->adjacency, (const qcCorners*)body->indices, body->triangleCount,
                             body->vertexCount));
    uint8_t* bends = qcAllocateZeroed(body->vertexCount);
    if (bends == NULL)
        return qcFailMemory(body->vertexCount, "the local-minimum filter");
    DropFlatEdges(localMinima, body, bends);
    for (size_t i = 0; i < 3 * (size_t)body->triangleCount; i++)
        if (!bends[body->indices[i]])
            QC_AT(qcOwnedFeatures, localMinima->owned, i / 3) &= (qcOwnedFeatures) ~(1u << i % 3);
    qcFree(bends, body->vertexCount);
    localMinima->generation = body->generation;
    return qc_statusOk;
}

qcStatus qcLocalMinima_Make(qcLocalMinima* localMinima, const qcBody* body)
{
    if (localMinima->generation == body->generation)
        return qc_statusOk;
    qcLocalMinima_Free(localMinima);
    if (body->triangleCount == 0)
        return qc_statusOk;
    qcStatus status = Make(localMinima, body);
    if (status != qc_statusOk)
        qcLocalMinima_Free(localMinima);
    return status;
}

void qcLocalMinima_Free(qcLocalMinima* localMinima)
{
    qcAdjacency_Free(&localMinima->adjacency);
    qcArray_Free(&localMinima->owned);
    localMinima->generation = 0;
}

bool qcLocalMinima_GetOppositeVertex(const qcLocalMinima* localMinima, const qcBody* body, uint32_t triangle, int edge,
                                     qcVector* opposite)
{
    uint32_t other = Across(localMinima, triangle, edge);
    if (other == QC_NO_SLOT)
        return false;
    const uint32_t* mine = body->indices + 3 * (size_t)triangle;
    const uint32_t* w = body->indices + 3 * (size_t)other;
    uint32_t p = mine[edge], q = mine[(edge + 1) % 3];
    uint32_t far = w[0] != p && w[0] != q ? w[0] : w[1] != p && w[1] != q ? w[1] : w[2];
    *opposite = WorldOf(body, far);
    return true;
}

static bool IsNearestCorner(const qcLocalMinima* localMinima, const qcBody* body, uint32_t vertex, qcVector outward)
{
    const uint32_t* first = &QC_AT(uint32_t, localMinima->adjacency.around.first, vertex);
    qcVector x = WorldOf(body, vertex);
    for (uint32_t i = first[0]; i < first[1]; i++)
    {
        const uint32_t* w = body->indices + 3 * (size_t)QC_AT(uint32_t, localMinima->adjacency.around.triangles, i);
        for (int c = 0; c < 3; c++)
            if (w[c] != vertex && !qcLocalMinima_LeadsAway(qcMinus(WorldOf(body, w[c]), x), outward))
                return false;
    }
    return true;
}

bool qcLocalMinima_IsNearest(const qcLocalMinima* localMinima, const qcBody* body, uint32_t triangle,
                             const double weights[3], qcVector outward)
{
    const uint32_t* v = body->indices + 3 * (size_t)triangle;
    for (int c = 0; c < 3; c++)
        if (weights[c] == 1.0)
            return IsNearestCorner(localMinima, body, v[c], outward);
    for (int c = 0; c < 3; c++)
    {
        qcVector opposite;
        int edge = (c + 1) % 3;
        if (weights[c] == 0.0 && qcLocalMinima_GetOppositeVertex(localMinima, body, triangle, edge, &opposite))
            return qcLocalMinima_LeadsAway(qcMinus(opposite, WorldOf(body, v[edge])), outward);
    }
    return true;
}
