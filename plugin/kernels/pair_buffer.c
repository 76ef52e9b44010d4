// Sinks of pairs.
#include "kernels/pair_buffer.h"

#include "base/status.h"

static void AddKey(qcArray* keys, uint64_t key)
{
    QC_AT(uint64_t, *keys, keys->count++) = key;
}

qcStatus qcPairBuffers_Begin(qcArray* sinks, uint32_t threads)
{
    QC_TRY(qcArray_GrowZeroed(sinks, threads, sizeof(qcPairBuffer), "candidate pairs"));
    for (size_t i = 0; i < sinks->count; i++)
    {
        qcPairBuffer* sink = &QC_AT(qcPairBuffer, *sinks, i);
        sink->keys.count = sink->contactKeys.count = sink->sure.count = 0;
        sink->status = qc_statusOk;
    }
    return qc_statusOk;
}

bool qcPairBuffer_Add(qcPairBuffer* sink, const qcClassifiedPairs* found, bool listKnown, qcPairKeyFunction* keyOf,
                      const void* context)
{
    qcArray* keyArrays[2] = {&sink->keys, &sink->contactKeys};
    for (int i = 0; i < 2 && sink->status == qc_statusOk; i++)
        sink->status =
            qcArray_Reserve(keyArrays[i], keyArrays[i]->count + found->count, sizeof(uint64_t), "candidate pairs");
    if (sink->status == qc_statusOk)
        sink->status =
            qcArray_Reserve(&sink->sure, sink->sure.count + found->count, sizeof(qcSortItem), "candidate pairs");
    if (sink->status != qc_statusOk)
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
    if (sink->status == qc_statusOk)
        sink->status =
            qcArray_Reserve(&sink->contactKeys, sink->contactKeys.count + count, sizeof(uint64_t), "neighbours");
    for (size_t i = 0; i < count && sink->status == qc_statusOk; i++)
        AddKey(&sink->contactKeys, keyOf(context, pairs[i]));
}

qcStatus qcPairBuffers_End(const qcArray* sinks, const qcPairKeys* keys)
{
    for (size_t i = 0; i < sinks->count; i++)
    {
        const qcPairBuffer* sink = &QC_AT(qcPairBuffer, *sinks, i);
        // The message is the worker's own; say it again on this thread.
        if (sink->status != qc_statusOk)
            return qcArray_FailAgain(&sink->keys, "candidate pairs");
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
