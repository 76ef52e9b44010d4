// Each conversion is exact.
#include "scene/float_positions.h"

#include "base/status.h"

#include <assert.h>

/// Bytes of a position array and one float more, rounded up to whole cache lines.
static size_t ArrayBytes(const qcBody* body)
{
    return (sizeof(float) * (3 * (size_t)body->vertexCount + 1) + 63) / 64 * 64;
}

static size_t ByteCount(const qcBody* body)
{
    return 64 + 2 * ArrayBytes(body);
}
_Static_assert(sizeof(struct qcFloatPositions) <= 64, "the arrays begin with a cache line");

/// Memory for the positions is first touched where they are read: not in the first step.
static qcStatus Allocate(qcBody* body)
{
    struct qcFloatPositions* floats = qcAllocate(ByteCount(body));
    if (floats == NULL)
        return qcFailMemory(ByteCount(body), "positions as floats");
    float* at = (float*)(void*)((char*)floats + 64);
    *floats = (struct qcFloatPositions){.at = at, .spare = (float*)(void*)((char*)at + ArrayBytes(body))};
    // The last vertex is read with one float more.
    floats->at[3 * (size_t)body->vertexCount] = floats->spare[3 * (size_t)body->vertexCount] = 0.0f;
    body->floats = floats;
    return qc_statusOk;
}

qcStatus qcFloatPositions_Keep(qcBody* body)
{
    if (!body->deforming || !body->hasFloats)
        return qc_statusOk;
    if (body->floats == NULL)
        QC_TRY(Allocate(body));
    assert(body->floats != NULL);
    body->floats->kept = true;
    return qc_statusOk;
}

void qcFloatPositions_Convert(const qcBody* body)
{
    if (!qcBody_IsInFloats(body))
        return;
    for (size_t i = 0; i < 3 * (size_t)body->vertexCount; i++)
        body->world[i] = (double)body->floats->at[i];
    body->floats->newest = false;
}

void qcFloatPositions_Leave(const qcBody* body)
{
    if (body->floats == NULL)
        return;
    qcFloatPositions_Convert(body);
    body->floats->kept = false;
}

void qcFloatPositions_Replace(qcBody* body)
{
    float* previous = body->floats->at;
    body->floats->at = body->floats->spare;
    body->floats->spare = previous;
    body->floats->newest = true;
}

void qcFloatPositions_Free(qcBody* body)
{
    if (body->floats != NULL)
        qcFree(body->floats, ByteCount(body));
    body->floats = NULL;
}
