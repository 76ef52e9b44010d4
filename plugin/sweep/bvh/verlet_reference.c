// Reference positions of a Verlet list.
#include "sweep/bvh/verlet_reference.h"

#include "base/status.h"

#include <string.h>

/// Depends on the topology alone.
static qcStatus IndexVertices(qcVerletReference* reference, const qcTriangleBvh* bvh, uint32_t vertexCount)
{
    if (reference->bvhVertex.count != 0)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&reference->bvhVertex, vertexCount, sizeof(uint32_t), "a Verlet list"));
    uint32_t* bvhVertex = reference->bvhVertex.data;
    for (uint32_t v = 0; v < vertexCount; v++)
        bvhVertex[v] = bvh->vertexCount;
    for (uint32_t i = 0; i < bvh->vertexCount; i++)
        bvhVertex[QC_AT(uint32_t, bvh->vertexOf, i)] = i;
    return qc_statusOk;
}

qcStatus qcVerletReference_Set(qcVerletReference* reference, const qcTriangleBvh* bvh, const qcBody* body,
                               double margin)
{
    size_t count = 3 * (size_t)body->vertexCount;
    qcVerletReference_Clear(reference);
    QC_TRY(IndexVertices(reference, bvh, body->vertexCount));
    QC_TRY(qcArray_Resize(&reference->motionFlags, bvh->corners.count, 1, "a Verlet list"));
    QC_TRY(qcArray_Resize(&reference->positions, count, sizeof(double), "a Verlet list"));
    memset(reference->motionFlags.data, qc_motionNone, reference->motionFlags.count);
    memcpy(reference->positions.data, body->world, count * sizeof(double));
    reference->fitCount = bvh->fit.fitCount;
    reference->margin = margin;
    return qc_statusOk;
}

void qcVerletReference_Clear(qcVerletReference* reference)
{
    reference->positions.count = 0;
    reference->movedVertices.count = 0;
}

bool qcVerletReference_IsValid(const qcVerletReference* reference, const qcTriangleBvh* bvh)
{
    return bvh->fit.fitted && reference->positions.count != 0 && reference->fitCount == bvh->fit.fitCount;
}

void qcVerletReference_Free(qcVerletReference* reference)
{
    qcArray_Free(&reference->positions);
    qcArray_Free(&reference->bvhVertex);
    qcArray_Free(&reference->movedVertices);
    qcArray_Free(&reference->motionFlags);
    *reference = (qcVerletReference){0};
}
