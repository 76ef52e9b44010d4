// Connected components of the graph of body pairs.
#include "sweep/islands.h"

#include "base/status.h"
#include "base/union_find.h"

#include <float.h>

static void Include(qcPlanItem* part, const qcBody* body)
{
    part->triangles += body->triangleCount;
    for (int axis = 0; axis < 3; axis++)
    {
        part->lower[axis] = body->lower[axis] < part->lower[axis] ? body->lower[axis] : part->lower[axis];
        part->upper[axis] = body->upper[axis] > part->upper[axis] ? body->upper[axis] : part->upper[axis];
    }
}

qcStatus qcIslands_Find(qcIslands* parts, const qcStepTriangles* triangles, const qcBodyPairs* objects)
{
    uint32_t bodyCount = triangles->bodyCount;
    parts->parts.count = 0;
    QC_TRY(qcArray_Resize(&parts->partOf, bodyCount, sizeof(uint32_t), "parts of the scene"));
    QC_TRY(qcArray_Reserve(&parts->parts, bodyCount, sizeof(qcPlanItem), "parts of the scene"));
    QC_TRY(qcArray_Resize(&parts->parents, bodyCount, sizeof(uint32_t), "parts of the scene"));
    uint32_t *partOf = parts->partOf.data, *parent = parts->parents.data;
    qcSigned_Init(parent, bodyCount);
    for (size_t i = 0; i < objects->pairs.count; i++)
    {
        qcBodyPair pair = QC_AT(qcBodyPair, objects->pairs, i);
        // The lowest body of an island is its root: the loop below visits it first.
        qcSigned_Unite(parent, pair.a, pair.b, 0);
    }
    for (uint32_t body = 0; body < bodyCount; body++)
        partOf[body] = QC_NO_ISLAND;
    for (size_t i = 0; i < objects->pairs.count; i++)
        partOf[QC_AT(qcBodyPair, objects->pairs, i).a] = partOf[QC_AT(qcBodyPair, objects->pairs, i).b] = 0;
    for (uint32_t body = 0; body < bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(triangles, body);
        if (partOf[body] == QC_NO_ISLAND && !qcBody_HasSelfCollision(b))
            continue;
        uint32_t root = qcSigned_Find(parent, body) >> 1;
        if (root == body)
        {
            partOf[body] = (uint32_t)parts->parts.count++;
            QC_AT(qcPlanItem, parts->parts, partOf[body]) =
                (qcPlanItem){.lower = {DBL_MAX, DBL_MAX, DBL_MAX}, .upper = {-DBL_MAX, -DBL_MAX, -DBL_MAX}};
        }
        else
            partOf[body] = partOf[root];
        Include(&QC_AT(qcPlanItem, parts->parts, partOf[body]), b);
    }
    return qc_statusOk;
}

void qcIslands_Unite(qcIslands* parts, uint8_t* flags)
{
    uint32_t* isWhole = parts->parents.data; // of each part; they are no more than bodies
    const uint32_t* partOf = parts->partOf.data;
    for (size_t i = 0; i < parts->parts.count; i++)
        isWhole[i] = 1;
    for (size_t body = 0; body < parts->partOf.count; body++)
        if (partOf[body] != QC_NO_ISLAND && !flags[body])
            isWhole[partOf[body]] = 0;
    for (size_t body = 0; body < parts->partOf.count; body++)
        flags[body] = partOf[body] != QC_NO_ISLAND && isWhole[partOf[body]];
}

void qcIslands_Free(qcIslands* parts)
{
    qcArray_Free(&parts->parts);
    qcArray_Free(&parts->partOf);
    qcArray_Free(&parts->parents);
}
