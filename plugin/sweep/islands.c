// Connected components of the graph of body pairs.
#include "sweep/islands.h"

#include "base/aabb.h"
#include "base/status.h"
#include "base/union_find.h"
#include "mesh/triangle_sample.h"

#include <float.h>
#include <math.h>

enum
{
    // Triangles of a body that are sampled. A few stray vertices do not change the median.
    qc_sampledTriangles = 9
};

static void Include(qcPlanItem* island, const qcBody* body)
{
    island->triangles += body->triangleCount;
    qcBounds_IncludeBox(body->lower, body->upper, island->lower, island->upper);
}

/// Fills the union-find forest, and marks the bodies of pairs in islandOf by 0, all others by QC_NO_ISLAND.
static void Unite(const qcBodyPairs* pairs, uint32_t bodyCount, uint32_t* parent, uint32_t* islandOf)
{
    qcUnionFind_Init(parent, bodyCount);
    for (uint32_t body = 0; body < bodyCount; body++)
        islandOf[body] = QC_NO_ISLAND;
    for (size_t i = 0; i < pairs->pairs.count; i++)
    {
        qcBodyPair pair = QC_AT(qcBodyPair, pairs->pairs, i);
        // The lowest body of an island is its root: a loop over bodies visits it first.
        qcUnionFind_Unite(parent, pair.a, pair.b, 0);
        islandOf[pair.a] = islandOf[pair.b] = 0;
    }
}

qcStatus qcIslands_Find(const qcStepTriangles* triangles, const qcBodyPairs* pairs, qcIslands* islands)
{
    uint32_t bodyCount = triangles->bodyCount;
    islands->items.count = 0;
    QC_TRY(qcArray_Resize(&islands->islandOf, bodyCount, sizeof(uint32_t), "islands"));
    QC_TRY(qcArray_Reserve(&islands->items, bodyCount, sizeof(qcPlanItem), "islands"));
    QC_TRY(qcArray_Resize(&islands->scratch, bodyCount, sizeof(uint32_t), "islands"));
    uint32_t *islandOf = islands->islandOf.data, *parent = islands->scratch.data;
    Unite(pairs, bodyCount, parent, islandOf);
    for (uint32_t body = 0; body < bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(triangles, body);
        if (islandOf[body] == QC_NO_ISLAND && !qcBody_HasSelfCollision(b))
            continue;
        uint32_t root = qcUnionFind_Find(parent, body) >> 1;
        if (root == body)
        {
            islandOf[body] = (uint32_t)islands->items.count++;
            qcPlanItem* island = &QC_AT(qcPlanItem, islands->items, islandOf[body]);
            *island = (qcPlanItem){.triangles = 0};
            qcBounds_Clear(island->lower, island->upper);
        }
        else
            islandOf[body] = islandOf[root];
        Include(&QC_AT(qcPlanItem, islands->items, islandOf[body]), b);
    }
    return qc_statusOk;
}

/// About the length of a body's triangles: the median of some, or by the body's box where its positions are on a device
/// only.
static double TriangleLength(const qcBody* body)
{
    if (body->snapshot != NULL || body->triangleCount < qc_sampledTriangles)
        return qcBounds_Widest(body->lower, body->upper) / sqrt(body->triangleCount);
    qcTriangleSample sample;
    sample.count = qc_sampledTriangles;
    for (uint32_t i = 0; i < qc_sampledTriangles; i++)
        qcBody_GetTriangle(body, (uint32_t)((uint64_t)i * body->triangleCount / qc_sampledTriangles),
                           sample.corners[i]);
    return qcTriangleSample_MedianSize(&sample);
}

void qcIslands_FindFinest(qcIslands* islands, const qcStepTriangles* triangles)
{
    const uint32_t* islandOf = islands->islandOf.data;
    qcPlanItem* items = islands->items.data;
    for (size_t i = 0; i < islands->items.count; i++)
        items[i].finest = DBL_MAX;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        if (islandOf[body] != QC_NO_ISLAND)
            items[islandOf[body]].finest =
                fmin(items[islandOf[body]].finest, TriangleLength(qcStepTriangles_Body(triangles, body)));
}

void qcIslands_KeepWhole(qcIslands* islands, uint8_t* flags)
{
    uint32_t* isWhole = islands->scratch.data; // by island: there are no more islands than bodies
    const uint32_t* islandOf = islands->islandOf.data;
    for (size_t i = 0; i < islands->items.count; i++)
        isWhole[i] = 1;
    for (size_t body = 0; body < islands->islandOf.count; body++)
        if (islandOf[body] != QC_NO_ISLAND && !flags[body])
            isWhole[islandOf[body]] = 0;
    for (size_t body = 0; body < islands->islandOf.count; body++)
        flags[body] = islandOf[body] != QC_NO_ISLAND && isWhole[islandOf[body]];
}

void qcIslands_LeaveSmall(qcIslands* islands, const qcStepTriangles* triangles, uint32_t maxSize, uint8_t* flags)
{
    uint32_t* isLarge = islands->scratch.data; // by island, as in qcIslands_KeepWhole
    const uint32_t* islandOf = islands->islandOf.data;
    for (size_t i = 0; i < islands->items.count; i++)
        isLarge[i] = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        if (islandOf[body] != QC_NO_ISLAND && qcStepTriangles_Body(triangles, body)->triangleCount > maxSize)
            isLarge[islandOf[body]] = 1;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        flags[body] = flags[body] && islandOf[body] != QC_NO_ISLAND && isLarge[islandOf[body]];
}

void qcIslands_Free(qcIslands* islands)
{
    qcArray_Free(&islands->items);
    qcArray_Free(&islands->islandOf);
    qcArray_Free(&islands->scratch);
}
