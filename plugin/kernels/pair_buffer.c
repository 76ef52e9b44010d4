// Buffers for pairs of triangles.
#include "kernels/pair_buffer.h"

#include "base/status.h"

/// Adds the keys of pairs, for which there is room. Returns where they are; null: there are none.
static uint64_t* AddKeys(qcArray* keys, const qcSlotPair* pairs, size_t count, qcPairKeysFunction* keysOf,
                         const void* context)
{
    if (count == 0)
        return NULL;
    uint64_t* first = (uint64_t*)keys->data + keys->count;
    keysOf(context, pairs, count, first);
    keys->count += count;
    return first;
}

static void AddRelated(qcArray* classified, const qcSlotPair* pairs, size_t count, qcRelation relation,
                       qcPairKeysFunction* keysOf, const void* context)
{
    uint64_t* keys = AddKeys(classified, pairs, count, keysOf, context);
    for (size_t i = 0; i < count; i++)
        keys[i] = qcRelatedPair_Make(keys[i], relation);
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
                      qcPairKeysFunction* keysOf, const void* context)
{
    if (!qcWorkerResult_IsOk(&buffer->result) || !qcWorkerResult_Add(&buffer->result, ReserveAll(buffer, found->count)))
        return false;
    size_t disjoint = found->nearCount + found->separateCount, classified = disjoint + found->intersectingCount;
    AddKeys(&buffer->keys, found->pairs + classified, found->count - classified, keysOf, context);
    AddRelated(&buffer->classified, found->pairs, found->nearCount, qc_relationNear, keysOf, context);
    AddRelated(&buffer->classified, found->pairs + disjoint, found->intersectingCount, qc_relationPenetrating, keysOf,
               context);
    if (listClassified)
        AddKeys(&buffer->contactKeys, found->pairs, classified, keysOf, context);
    return true;
}

void qcPairBuffer_AddNeighbours(qcPairBuffer* buffer, const qcSlotPair* pairs, size_t count, qcPairKeysFunction* keysOf,
                                const void* context)
{
    qcStatus status = qcRelatedPair_CheckCount(buffer->contactKeys.count + count, buffer->maxPairs);
    if (status == qc_statusOk)
        status =
            qcArray_Reserve(&buffer->contactKeys, buffer->contactKeys.count + count, sizeof(uint64_t), "neighbours");
    if (qcWorkerResult_Add(&buffer->result, status))
        AddKeys(&buffer->contactKeys, pairs, count, keysOf, context);
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
