// Buffers for pairs of triangles.
#include "kernels/pair_buffer.h"

#include "base/status.h"

static void AddKey(qcArray* keys, uint64_t key)
{
    QC_AT(uint64_t, *keys, keys->count++) = key;
}

qcStatus qcPairBuffers_Begin(qcArray* buffers, uint32_t threads)
{
    QC_TRY(qcArray_GrowZeroed(buffers, threads, sizeof(qcPairBuffer), "candidate pairs"));
    for (size_t i = 0; i < buffers->count; i++)
    {
        qcPairBuffer* buffer = &QC_AT(qcPairBuffer, *buffers, i);
        buffer->keys.count = buffer->contactKeys.count = buffer->classified.count = 0;
        buffer->status = qc_statusOk;
    }
    return qc_statusOk;
}

bool qcPairBuffer_Add(qcPairBuffer* buffer, const qcClassifiedPairs* found, bool listClassified,
                      qcPairKeyFunction* keyOf, const void* context)
{
    qcArray* keyArrays[2] = {&buffer->keys, &buffer->contactKeys};
    for (int i = 0; i < 2 && buffer->status == qc_statusOk; i++)
        buffer->status =
            qcArray_Reserve(keyArrays[i], keyArrays[i]->count + found->count, sizeof(uint64_t), "candidate pairs");
    if (buffer->status == qc_statusOk)
        buffer->status = qcArray_Reserve(&buffer->classified, buffer->classified.count + found->count,
                                         sizeof(qcSortItem), "candidate pairs");
    if (buffer->status != qc_statusOk)
        return false;
    size_t classified = found->nearCount + found->separateCount + found->intersectingCount;
    for (size_t i = 0; i < found->count; i++)
    {
        uint64_t key = keyOf(context, found->pairs[i]);
        if (i >= classified)
            AddKey(&buffer->keys, key);
        else if (i < found->nearCount || i >= found->nearCount + found->separateCount)
            QC_AT(qcSortItem, buffer->classified, buffer->classified.count++) =
                (qcSortItem){key, i < found->nearCount ? qc_relationNear : qc_relationPenetrating};
        if (i < classified && listClassified)
            AddKey(&buffer->contactKeys, key);
    }
    return true;
}

void qcPairBuffer_AddNeighbours(qcPairBuffer* buffer, const qcSlotPair* pairs, size_t count, qcPairKeyFunction* keyOf,
                                const void* context)
{
    if (buffer->status == qc_statusOk)
        buffer->status =
            qcArray_Reserve(&buffer->contactKeys, buffer->contactKeys.count + count, sizeof(uint64_t), "neighbours");
    for (size_t i = 0; i < count && buffer->status == qc_statusOk; i++)
        AddKey(&buffer->contactKeys, keyOf(context, pairs[i]));
}

qcStatus qcPairBuffers_End(const qcArray* buffers, const qcPairKeys* keys)
{
    for (size_t i = 0; i < buffers->count; i++)
    {
        const qcPairBuffer* buffer = &QC_AT(qcPairBuffer, *buffers, i);
        // Copy the worker's error message to this thread.
        if (buffer->status != qc_statusOk)
            return qcArray_FailAgain(&buffer->keys, "candidate pairs");
        QC_TRY(qcArray_Append(keys->keys, &buffer->keys, sizeof(uint64_t), "candidate pairs"));
        QC_TRY(qcArray_Append(keys->contactKeys, &buffer->contactKeys, sizeof(uint64_t), "candidate pairs"));
        QC_TRY(qcArray_Append(keys->classified, &buffer->classified, sizeof(qcSortItem), "candidate pairs"));
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
