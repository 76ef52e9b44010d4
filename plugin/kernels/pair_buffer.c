// Buffers for pairs of triangles.
#include "kernels/pair_buffer.h"

#include "base/status.h"

static void AddKey(qcArray* keys, uint64_t key)
{
    QC_AT(uint64_t, *keys, keys->count++) = key;
}

qcStatus qcPairBuffers_Begin(qcArray* buffers, uint32_t threads, uint64_t maxPairs)
{
    QC_TRY(qcWorkerResults_Begin(buffers, threads, sizeof(qcPairBuffer), "candidate pairs"));
    for (size_t i = 0; i < buffers->count; i++)
    {
        qcPairBuffer* buffer = &QC_AT(qcPairBuffer, *buffers, i);
        buffer->keys.count = buffer->contactKeys.count = buffer->classified.count = 0;
        buffer->maxPairs = maxPairs;
    }
    return qc_statusOk;
}

static qcStatus ReserveAll(qcPairBuffer* buffer, size_t count)
{
    QC_TRY(qcRelatedPair_CheckCount(buffer->keys.count + buffer->classified.count, buffer->maxPairs));
    QC_TRY(qcRelatedPair_CheckCount(buffer->contactKeys.count, buffer->maxPairs));
    QC_TRY(qcArray_Reserve(&buffer->keys, buffer->keys.count + count, sizeof(uint64_t), "candidate pairs"));
    QC_TRY(
        qcArray_Reserve(&buffer->contactKeys, buffer->contactKeys.count + count, sizeof(uint64_t), "candidate pairs"));
    return qcArray_Reserve(&buffer->classified, buffer->classified.count + count, sizeof(uint64_t), "candidate pairs");
}

bool qcPairBuffer_Add(qcPairBuffer* buffer, const qcClassifiedPairs* found, bool listClassified,
                      qcPairKeyFunction* keyOf, const void* context)
{
    if (!qcWorkerResult_IsOk(&buffer->result) || !qcWorkerResult_Add(&buffer->result, ReserveAll(buffer, found->count)))
        return false;
    size_t classified = found->nearCount + found->separateCount + found->intersectingCount;
    for (size_t i = 0; i < found->count; i++)
    {
        uint64_t key = keyOf(context, found->pairs[i]);
        if (i >= classified)
            AddKey(&buffer->keys, key);
        else if (i < found->nearCount || i >= found->nearCount + found->separateCount)
            AddKey(&buffer->classified,
                   qcRelatedPair_Make(key, i < found->nearCount ? qc_relationNear : qc_relationPenetrating));
        if (i < classified && listClassified)
            AddKey(&buffer->contactKeys, key);
    }
    return true;
}

void qcPairBuffer_AddNeighbours(qcPairBuffer* buffer, const qcSlotPair* pairs, size_t count, qcPairKeyFunction* keyOf,
                                const void* context)
{
    qcStatus status = qcRelatedPair_CheckCount(buffer->contactKeys.count + count, buffer->maxPairs);
    if (status == qc_statusOk)
        status =
            qcArray_Reserve(&buffer->contactKeys, buffer->contactKeys.count + count, sizeof(uint64_t), "neighbours");
    if (!qcWorkerResult_Add(&buffer->result, status))
        return;
    for (size_t i = 0; i < count; i++)
        AddKey(&buffer->contactKeys, keyOf(context, pairs[i]));
}

qcStatus qcPairBuffers_End(const qcArray* buffers, const qcPairKeys* keys)
{
    QC_TRY(qcWorkerResults_End(buffers, sizeof(qcPairBuffer)));
    for (size_t i = 0; i < buffers->count; i++)
    {
        const qcPairBuffer* buffer = &QC_AT(qcPairBuffer, *buffers, i);
        QC_TRY(qcArray_Append(keys->keys, &buffer->keys, sizeof(uint64_t), "candidate pairs"));
        QC_TRY(qcArray_Append(keys->contactKeys, &buffer->contactKeys, sizeof(uint64_t), "candidate pairs"));
        QC_TRY(qcArray_Append(keys->classified, &buffer->classified, sizeof(uint64_t), "candidate pairs"));
    }
    return qc_statusOk;
}

void qcPairBuffers_Free(qcArray* buffers)
{
    for (size_t i = 0; i < buffers->count; i++)
    {
        qcArray_Free(&QC_AT(qcPairBuffer, *buffers, i).keys);
        qcArray_Free(&QC_AT(qcPairBuffer, *buffers, i).contactKeys);
        qcArray_Free(&QC_AT(qcPairBuffer, *buffers, i).classified);
    }
    qcArray_Free(buffers);
}
