// Which contacts of a deforming body with a rigid one bind: those at points of the rigid body's surface to which
// nothing around them is nearer. Local minima of distance: Johnson, Cohen: A Framework for Efficient Minimum Distance
// Computations, 1998; the normal cones of edges and vertices: Johnson, Willemsen: Six Degree-of-Freedom Haptic
// Rendering of Complex Polygonal Models, 2003.
//
// Why nothing is lost with the others. Where a neighbour of a point is nearer, go there: distance falls all the way
// down to a point that is nearest, whose contact is of the same vertex, is nearer, and is kept. What keeps that off by
// the margin keeps the vertex off the whole surface around; the others would push it sideways along the surface, as
// though each triangle were a body by itself. The rigid side alone counts: a vertex of the deforming body moves by
// itself, so each has its own contacts.
//
// Edges and corners of the rigid body that are flat are never met as such. Whatever is over one is as far from the
// surface beside it, so follow it until it ends, at a vertex over a face, or until the surface does, or turns, at an
// edge or corner that is not flat.
#include "narrowphase/local_minimum.h"

#include "base/status.h"

#include <string.h>

// Angle between triangles, in radians, below which an edge is flat: more than single precision makes of a plane, and so
// little that an edge over a thousand of them in a row is off by an 80th of its length.
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

static uint32_t Across(const qcLocalMinima* surroundings, uint32_t triangle, int edge)
{
    return QC_AT(uint32_t, surroundings->adjacency.across, 3 * (size_t)triangle + (size_t)edge);
}

static bool IsFlatEdge(const qcLocalMinima* surroundings, const qcBody* body, uint32_t triangle, int edge)
{
    uint32_t other = Across(surroundings, triangle, edge);
    if (other == QC_NO_SLOT)
        return false;
    qcVector m = NormalOf(body, triangle), n = NormalOf(body, other), c = qcCross(m, n);
    return qcDot(m, n) > 0.0 && qcDot(c, c) <= s_flat * s_flat * qcDot(m, m) * qcDot(n, n);
}

/// Marks the vertices of edges that are not flat, and leaves out the edges that are.
static void KeepEdges(qcLocalMinima* surroundings, const qcBody* body, uint8_t* turns)
{
    for (uint32_t t = 0; t < body->triangleCount; t++)
    {
        const uint32_t* v = body->indices + 3 * (size_t)t;
        unsigned owned = body->owned[t];
        for (int e = 0; e < 3; e++)
            if (IsFlatEdge(surroundings, body, t, e))
                owned &= ~(8u << e);
            else
                turns[v[e]] = turns[v[(e + 1) % 3]] = 1;
        QC_AT(qcOwnedFeatures, surroundings->owned, t) = (qcOwnedFeatures)owned;
    }
}

static qcStatus Make(qcLocalMinima* surroundings, const qcBody* body)
{
    QC_TRY(qcArray_Resize(&surroundings->owned, body->triangleCount, sizeof(qcOwnedFeatures), "surroundings"));
    // The triangles themselves stand for their places.
    QC_TRY(qcAdjacency_Build(&surroundings->adjacency, (const qcCorners*)body->indices, body->triangleCount,
                             body->vertexCount));
    uint8_t* turns = qcAllocateZeroed(body->vertexCount);
    if (turns == NULL)
        return qcFailMemory(body->vertexCount, "surroundings");
    KeepEdges(surroundings, body, turns);
    for (size_t i = 0; i < 3 * (size_t)body->triangleCount; i++)
        if (!turns[body->indices[i]])
            QC_AT(qcOwnedFeatures, surroundings->owned, i / 3) &= (qcOwnedFeatures) ~(1u << i % 3);
    qcFree(turns, body->vertexCount);
    surroundings->generation = body->generation;
    return qc_statusOk;
}

qcStatus qcLocalMinima_Make(qcLocalMinima* surroundings, const qcBody* body)
{
    if (surroundings->generation == body->generation)
        return qc_statusOk;
    qcLocalMinima_Free(surroundings);
    if (body->triangleCount == 0)
        return qc_statusOk;
    qcStatus status = Make(surroundings, body);
    if (status != qc_statusOk)
        qcLocalMinima_Free(surroundings);
    return status;
}

void qcLocalMinima_Free(qcLocalMinima* surroundings)
{
    qcAdjacency_Free(&surroundings->adjacency);
    qcArray_Free(&surroundings->owned);
    surroundings->generation = 0;
}

bool qcLocalMinima_GetOver(const qcLocalMinima* surroundings, const qcBody* body, uint32_t triangle, int edge,
                           qcVector* over)
{
    uint32_t other = Across(surroundings, triangle, edge);
    if (other == QC_NO_SLOT)
        return false;
    const uint32_t* mine = body->indices + 3 * (size_t)triangle;
    const uint32_t* w = body->indices + 3 * (size_t)other;
    uint32_t p = mine[edge], q = mine[(edge + 1) % 3];
    uint32_t far = w[0] != p && w[0] != q ? w[0] : w[1] != p && w[1] != q ? w[1] : w[2];
    *over = WorldOf(body, far);
    return true;
}

static bool IsNearestCorner(const qcLocalMinima* surroundings, const qcBody* body, uint32_t vertex, qcVector outward)
{
    const uint32_t* first = &QC_AT(uint32_t, surroundings->adjacency.around.first, vertex);
    qcVector x = WorldOf(body, vertex);
    for (uint32_t i = first[0]; i < first[1]; i++)
    {
        const uint32_t* w = body->indices + 3 * (size_t)QC_AT(uint32_t, surroundings->adjacency.around.triangles, i);
        for (int c = 0; c < 3; c++)
            if (w[c] != vertex && !qcLocalMinima_LeadsAway(qcMinus(WorldOf(body, w[c]), x), outward))
                return false;
    }
    return true;
}

bool qcLocalMinima_IsNearest(const qcLocalMinima* surroundings, const qcBody* body, uint32_t triangle,
                             const double weights[3], qcVector outward)
{
    const uint32_t* v = body->indices + 3 * (size_t)triangle;
    for (int c = 0; c < 3; c++)
        if (weights[c] == 1.0)
            return IsNearestCorner(surroundings, body, v[c], outward);
    for (int c = 0; c < 3; c++)
    {
        qcVector over;
        int edge = (c + 1) % 3;
        if (weights[c] == 0.0 && qcLocalMinima_GetOver(surroundings, body, triangle, edge, &over))
            return qcLocalMinima_LeadsAway(qcMinus(over, WorldOf(body, v[edge])), outward);
    }
    return true;
}
