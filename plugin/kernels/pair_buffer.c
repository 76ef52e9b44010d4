// Sinks of pairs.
#include "kernels/pair_buffer.h"

#include "base/status.h"

static void AddKey(qcArray* keys, uint64_t key)
{
    QC_AT(uint64_t, *keys, keys->count++) = key;
}

qcStatus qcPairBuffers_Begin(qcArray* sinks, uint32_t threads)
{
    QC_TRY(qcWorkerResults_Begin(sinks, threads, sizeof(qcPairBuffer), "candidate pairs"));
    for (size_t i = 0; i < sinks->count; i++)
    {
        qcPairBuffer* sink = &QC_AT(qcPairBuffer, *sinks, i);
        sink->keys.count = sink->contactKeys.count = sink->sure.count = 0;
    }
    return qc_statusOk;
}

static qcStatus ReserveAll(qcPairBuffer* sink, size_t count)
{
    QC_TRY(qcArray_Reserve(&sink->keys, sink->keys.count + count, sizeof(uint64_t), "candidate pairs"));
    QC_TRY(qcArray_Reserve(&sink->contactKeys, sink->contactKeys.count + count, sizeof(uint64_t), "candidate pairs"));
    return qcArray_Reserve(&sink->sure, sink->sure.count + count, sizeof(qcSortItem), "candidate pairs");
}

bool qcPairBuffer_Add(qcPairBuffer* sink, const qcClassifiedPairs* found, bool listKnown, qcPairKeyFunction* keyOf,
                      const void* context)
{
    if (!qcWorkerResult_IsOk(&sink->result) || !qcWorkerResult_Add(&sink->result, ReserveAll(sink, found->count)))
        return false;
    size_t known = found->near + found->apart + found->penetrating;
    for (size_t i = 0; i < found->count; i++)
    {
        uint64_t key = keyOf(context, found->pairs[i]);
        if (i >= known)
            AddKey(&sink->keys, key);
        else if (i < found->near || i >= found->near + found->apart)
            QC_AT(qcSortItem, sink->sure, sink->sure.count++) =
                (qcSortItem){key, i < found->near ? qc_relationNear : qc_relationPenetrating};
        if (i < known && listKnown)
            AddKey(&sink->contactKeys, key);
    }
    return true;
}

void qcPairBuffer_AddNeighbours(qcPairBuffer* sink, const qcSlotPair* pairs, size_t count, qcPairKeyFunction* keyOf,
                                const void* context)
{
    qcStatus status =
        qcArray_Reserve(&sink->contactKeys, sink->contactKeys.count + count, sizeof(uint64_t), "neighbours");
    if (!qcWorkerResult_Add(&sink->result, status))
        return;
    for (size_t i = 0; i < count; i++)
        AddKey(&sink->contactKeys, keyOf(context, pairs[i]));
}

qcStatus qcPairBuffers_End(const qcArray* sinks, const qcPairKeys* keys)
{
    QC_TRY(qcWorkerResults_End(sinks, sizeof(qcPairBuffer)));
    for (size_t i = 0; i < sinks->count; i++)
    {
        const qcPairBuffer* sink = &QC_AT(qcPairBuffer, *sinks, i);
        QC_TRY(qcArray_Append(keys->keys, &sink->keys, sizeof(uint64_t), "candidate pairs"));
        QC_TRY(qcArray_Append(keys->contactKeys, &sink->contactKeys, sizeof(uint64_t), "candidate pairs"));
        QC_TRY(qcArray_Append(keys->sure, &sink->sure, sizeof(qcSortItem), "candidate pairs"));
    }
    return qc_statusOk;
}

void qcPairBuffers_Free(qcArray* sinks)
{
    for (size_t i = 0; i < sinks->count; i++)
    {
        qcArray_Free(&QC_AT(qcPairBuffer, *sinks, i).keys);
        qcArray_Free(&QC_AT(qcPairBuffer, *sinks, i).contactKeys);
        qcArray_Free(&QC_AT(qcPairBuffer, *sinks, i).sure);
    }
    qcArray_Free(sinks);
}
