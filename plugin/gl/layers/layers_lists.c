// Sizes of lists, by what the last run counted.
#include "gl/layers/layers_lists.h"

#include "base/status.h"
#include "gl/layers/layers_kernels.h"

enum
{
    // No kernel adds 2^31 items at once, and each notices a counter that has reached 2^31: none wraps around unseen.
    qc_maxItems = 1 << 25,
    qc_spareItems = 4096,
    // Bytes of an element of qc_workNodePairs.
    qc_nodePairBytes = 16,
    // Workgroups that find pairs of triangles, while each takes few pairs of nodes (H200: a folded cloth of 20 K
    // triangles has 2300 pairs of nodes, 4 a workgroup, a tangled one of 92 K has 15 000, 8 a workgroup).
    qc_pairingGroups = 2560,
    // With as many pairs of triangles or more the device puts them in order: that takes a GPU some 10 microseconds, and
    // a processor 12 for a thousand. Buckets are many, since pairs lie in few places: of the bench's tangles and piles
    // none has more than 500 pairs, on average 14 to 60.
    qc_minOrdered = 4096,
    qc_pairsOfBucket = 64,
    qc_minBuckets = 1024,
    qc_maxBuckets = 4096,
    // Rounds of a workgroup that goes through a list, so that no implementation stops its loops after 65 535
    // iterations: a round of triangle pairs has up to 564.
    qc_maxRounds = 32
};

static const int s_lists[qc_layersListCount] = {qc_workEntries, qc_workNodePairs, qc_workTrianglePairs, qc_workResults};
/// Room in a list's buffer that is none of the list's: for the item that doesn't fit, and for the counters.
static const uint32_t s_reserved[qc_layersListCount] = {1, 1, 1, 1 + qc_counterWords / 2};

/// Whether the kernels fill a list.
static bool IsFilled(const qcLayersLists* lists, int list)
{
    return lists->imageOnly == (list == qc_listEntries);
}

uint32_t qcLayersLists_Capacity(const qcLayersLists* lists, qcLayersList list)
{
    return lists->room[list] > s_reserved[list] ? lists->room[list] - s_reserved[list] : 0;
}

void qcLayersLists_ChooseBuckets(qcLayersLists* lists, uint32_t triangleCount)
{
    uint32_t pairs = qcLayersLists_Count(lists, qc_listSurvivors), last = triangleCount - 1, buckets = qc_minBuckets;
    lists->bucketCount = lists->bucketShift = 0;
    if (lists->imageOnly || pairs < qc_minOrdered)
        return;
    while (buckets < qc_maxBuckets && pairs / qc_pairsOfBucket > buckets)
        buckets *= 2;
    while (last >> lists->bucketShift >= buckets)
        lists->bucketShift++;
    lists->bucketCount = (last >> lists->bucketShift) + 1;
}

/// About as many as in the last run.
static uint64_t ExpectedItems(const qcLayersLists* lists, qcLayersList list)
{
    uint64_t capacity = qcLayersLists_Capacity(lists, list), last = qcLayersLists_Count(lists, list);
    uint64_t items = last != 0 ? last + last / 4 : capacity / 8;
    return items < capacity ? items : capacity;
}

uint32_t qcLayersLists_NodePairsOfGroup(const qcLayersLists* lists)
{
    uint32_t count = qc_minNodePairs;
    while (count < qc_maxNodePairs && ExpectedItems(lists, qc_listNodePairs) > (uint64_t)count * qc_pairingGroups)
        count *= 2;
    return count;
}

uint64_t qcLayersLists_GroupCount(const qcLayersLists* lists, qcLayersList list, uint32_t share)
{
    uint64_t expected = ExpectedItems(lists, list), min = qcLayersLists_Capacity(lists, list) / qc_maxRounds;
    return (expected > min ? expected : min) / share + 1;
}

static qcStatus ReserveElements(const struct qcGlFunctions* gl, qcLayersBuffers* buffers, int buffer, size_t count)
{
    bool fits = count <= buffers->capacity[buffer];
    return fits ? qc_statusOk : qcLayersBuffers_Resize(gl, buffers, buffer, count);
}

/// Makes room for a list of `count` elements, and a quarter more if it grows.
static qcStatus ReserveList(const struct qcGlFunctions* gl, qcLayersLists* lists, qcLayersBuffers* buffers, int list,
                            size_t count)
{
    if (count <= lists->room[list])
        return qc_statusOk;
    QC_TRY(ReserveElements(gl, buffers, s_lists[list], count + count / 4));
    lists->room[list] = (uint32_t)(count + count / 4);
    return qc_statusOk;
}

qcStatus qcLayersLists_Reserve(const struct qcGlFunctions* gl, qcLayersLists* lists, qcLayersBuffers* buffers,
                               size_t nodes)
{
    // Items per node that a folded cloth needs, and enough for most small scenes; one that needs more takes one more
    // run.
    static const size_t s_itemsPerNode[qc_layersListCount] = {4, 12, 64, 8};
    // Never empty: a block of a kernel needs a buffer.
    for (int list = 0; list < qc_layersListCount; list++)
        QC_TRY(ReserveList(gl, lists, buffers, list,
                           IsFilled(lists, list) ? s_itemsPerNode[list] * nodes + qc_spareItems : 1));
    // At most 16 MiB, which each GL allows.
    return ReserveElements(gl, buffers, qc_workNodePairs,
                           (size_t)lists->bucketCount * qc_bucketSize * sizeof(uint64_t) / qc_nodePairBytes);
}

qcStatus qcLayersLists_Grow(const struct qcGlFunctions* gl, qcLayersLists* lists, qcLayersBuffers* buffers, bool* grown)
{
    *grown = false;
    for (int list = 0; list < qc_layersListCount; list++)
    {
        uint32_t count = qcLayersLists_Count(lists, (qcLayersList)list);
        if (!IsFilled(lists, list))
            continue;
        if (count > qc_maxItems || lists->counters.overflow.count != 0)
            return qcFail(qc_statusDevice, "layers: more than %d pairs in one list", qc_maxItems);
        if (count <= qcLayersLists_Capacity(lists, (qcLayersList)list))
            continue;
        QC_TRY(ReserveList(gl, lists, buffers, list, (size_t)count + s_reserved[list] + 1));
        *grown = true;
    }
    return qc_statusOk;
}
