// A bitmap of global triangle indices, in two levels so that empty parts cost nothing, then lists.
#include "pipeline/pcs_report.h"

#include "base/parallel_for.h"
#include "base/status.h"

enum
{
    // A block takes some 20 microseconds.
    qc_pairsOfBlock = 4096,
    qc_minBlocks = 4
};

static void Mark(qcPcsReport* report, uint32_t triangle)
{
    uint64_t* word = &QC_AT(uint64_t, report->bits, triangle / 64);
    uint64_t bit = UINT64_C(1) << triangle % 64;
    report->marked += (*word & bit) == 0;
    *word |= bit;
    QC_AT(uint64_t, report->groups, triangle / 4096) |= UINT64_C(1) << triangle / 64 % 64;
}

static void MarkKey(qcPcsReport* report, uint64_t key)
{
    Mark(report, (uint32_t)(key >> 32));
    Mark(report, (uint32_t)key);
}

/// Marks a triangle while other threads mark others; report->marked is not changed.
static void MarkShared(const qcPcsReport* report, uint32_t triangle)
{
    uint64_t *word = &QC_AT(uint64_t, report->bits, triangle / 64), bit = UINT64_C(1) << triangle % 64;
    if ((__atomic_load_n(word, __ATOMIC_RELAXED) & bit) == 0 && __atomic_fetch_or(word, bit, __ATOMIC_RELAXED) == 0)
        __atomic_fetch_or(&QC_AT(uint64_t, report->groups, triangle / 4096), UINT64_C(1) << triangle / 64 % 64,
                          __ATOMIC_RELAXED);
}

typedef struct Marking
{
    const qcCandidates* candidates;
    qcPcsReport* report;
} Marking;

static void MarkBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Marking* marking = context;
    const qcArray* classified = &marking->candidates->classified;
    size_t end = (block + 1) * qc_pairsOfBlock;
    end = end < classified->count ? end : classified->count;
    for (size_t i = block * qc_pairsOfBlock; i < end; i++)
    {
        uint64_t key = qcRelatedPair_Key(QC_AT(uint64_t, *classified, i));
        MarkShared(marking->report, (uint32_t)(key >> 32));
        MarkShared(marking->report, (uint32_t)key);
    }
}

static size_t CountMarked(const qcPcsReport* report)
{
    size_t count = 0;
    for (size_t w = 0; w < report->bits.count; w++)
        count += (size_t)__builtin_popcountll(QC_AT(uint64_t, report->bits, w));
    return count;
}

/// Classified pairs: most of a tangle.
static void MarkClassified(const qcCandidates* candidates, uint32_t threads, qcPcsReport* report)
{
    size_t count = candidates->classified.count, blocks = (count + qc_pairsOfBlock - 1) / qc_pairsOfBlock;
    if (threads > 1 && blocks >= qc_minBlocks)
    {
        Marking marking = {candidates, report};
        qcParallel_For(threads, blocks, qc_minBlocks, MarkBlock, &marking);
        report->marked = CountMarked(report);
        return;
    }
    const uint64_t* classified = candidates->classified.data;
    for (size_t i = 0; i < count; i++)
        MarkKey(report, qcRelatedPair_Key(classified[i]));
}

static void MarkAll(const qcStepTriangles* triangles, const qcPcs* pcs, const qcCandidates* candidates, bool ofImage,
                    uint32_t threads, qcPcsReport* report)
{
    for (uint32_t triangle = 0; ofImage && triangle < triangles->count; triangle++)
        if (QC_AT(uint8_t, pcs->triangleSets, triangle) != 0)
            Mark(report, triangle);
    const uint64_t* keys = candidates->keys.data;
    for (size_t i = 0; !ofImage && i < candidates->keys.count; i++)
        MarkKey(report, keys[i]);
    MarkClassified(candidates, threads, report);
}

/// Takes the lowest bit of a word that is not 0.
static uint32_t TakeBit(uint64_t* word)
{
    uint32_t bit = (uint32_t)__builtin_ctzll(*word);
    *word &= *word - 1;
    return bit;
}

/// Lists the marked triangles, and clears the marks.
static void TakeMarked(const qcStepTriangles* triangles, qcPcsReport* report)
{
    size_t at = 0;
    uint32_t body = 0;
    for (size_t g = 0; g < report->groups.count; g++)
    {
        for (uint64_t words = QC_AT(uint64_t, report->groups, g); words != 0;)
        {
            size_t w = 64 * g + TakeBit(&words);
            for (uint64_t left = QC_AT(uint64_t, report->bits, w); left != 0;)
            {
                uint32_t triangle = (uint32_t)(64 * w) + TakeBit(&left);
                while (triangle >= qcStepTriangles_First(triangles, body + 1))
                    body++;
                QC_AT(qcTriangleRef, report->triangles, at++) = (qcTriangleRef){
                    qcStepTriangles_Slot(triangles, body), triangle - qcStepTriangles_First(triangles, body)};
            }
            QC_AT(uint64_t, report->bits, w) = 0;
        }
        QC_AT(uint64_t, report->groups, g) = 0;
    }
}

static qcStatus ListTriangles(const qcStepTriangles* triangles, qcPcsReport* report)
{
    qcStatus status = qcArray_Resize(&report->triangles, report->marked, sizeof(qcTriangleRef), "the PCS");
    if (status == qc_statusOk)
        TakeMarked(triangles, report);
    else
        report->bits.count = report->groups.count = 0; // the next step clears them
    return status;
}

/// Fills the sets of the listed triangles, in the same order.
static qcStatus ListSets(const qcPcs* pcs, qcPcsReport* report)
{
    QC_TRY(qcArray_Resize(&report->sets, report->triangles.count, sizeof(qcTriangleSets), "the sets of the PCS"));
    size_t at = 0;
    for (size_t triangle = 0; triangle < pcs->triangleSets.count; triangle++)
    {
        uint8_t packed = QC_AT(uint8_t, pcs->triangleSets, triangle);
        if (packed != 0)
            QC_AT(qcTriangleSets, report->sets, at++) =
                (qcTriangleSets){(uint8_t)qcPcs_InterSet(packed), (uint8_t)qcPcs_SelfSet(packed)};
    }
    return qc_statusOk;
}

static qcTriangleRef RefOf(const qcStepTriangles* triangles, uint32_t global)
{
    uint32_t body = qcStepTriangles_BodyOf(triangles, global);
    return (qcTriangleRef){qcStepTriangles_Slot(triangles, body), global - qcStepTriangles_First(triangles, body)};
}

static bool AreNeighbours(const qcStepTriangles* triangles, uint64_t key)
{
    uint32_t a = (uint32_t)(key >> 32), b = (uint32_t)key, body = qcStepTriangles_BodyOf(triangles, a);
    uint32_t first = qcStepTriangles_First(triangles, body);
    return body == qcStepTriangles_BodyOf(triangles, b) &&
           qcBody_AreNeighbours(qcStepTriangles_Body(triangles, body), a - first, b - first);
}

/// Fills report->items with the keys, in order. Pairs for contacts, but for neighbours, are candidates too.
static qcStatus SortKeys(const qcStepTriangles* triangles, const qcCandidates* candidates, qcPcsReport* report)
{
    const uint64_t *keys = candidates->keys.data, *contactKeys = candidates->contactKeys.data;
    const uint64_t* classified = candidates->classified.data;
    size_t count = 0;
    QC_TRY(qcArray_Resize(&report->items,
                          candidates->keys.count + candidates->contactKeys.count + candidates->classified.count,
                          sizeof(uint64_t), "the candidates"));
    uint64_t* items = report->items.data;
    for (size_t i = 0; i < candidates->keys.count; i++)
        items[count++] = keys[i];
    for (size_t i = 0; i < candidates->classified.count; i++)
        items[count++] = qcRelatedPair_Key(classified[i]);
    for (size_t i = 0; i < candidates->contactKeys.count; i++)
        if (!AreNeighbours(triangles, contactKeys[i]))
            items[count++] = contactKeys[i];
    report->items.count = count;
    return qcSort_Keys(items, count, &report->scratch);
}

static qcStatus ListCandidates(const qcStepTriangles* triangles, const qcCandidates* candidates, qcPcsReport* report)
{
    QC_TRY(SortKeys(triangles, candidates, report));
    QC_TRY(qcArray_Resize(&report->pairs, report->items.count, sizeof(qcCandidate), "the candidates"));
    size_t at = 0;
    for (size_t i = 0; i < report->items.count; i++)
    {
        uint64_t key = QC_AT(uint64_t, report->items, i);
        // Classified pairs are listed for contacts, too.
        if (i != 0 && key == QC_AT(uint64_t, report->items, i - 1))
            continue;
        qcTriangleRef a = RefOf(triangles, (uint32_t)(key >> 32)), b = RefOf(triangles, (uint32_t)key);
        QC_AT(qcCandidate, report->pairs, at++) = (qcCandidate){a.body, a.triangle, b.body, b.triangle};
    }
    report->pairs.count = at;
    return qc_statusOk;
}

qcStatus qcPcsReport_Fill(const qcStepTriangles* triangles, const qcPcs* pcs, const qcCandidates* candidates,
                          bool ofImage, const qcDetectDef* def, uint32_t threads, qcPcsReport* report)
{
    size_t words = ((size_t)triangles->count + 63) / 64;
    report->sets.count = report->pairs.count = report->marked = 0;
    QC_TRY(qcArray_GrowZeroed(&report->bits, words, sizeof(uint64_t), "the PCS"));
    QC_TRY(qcArray_GrowZeroed(&report->groups, (words + 63) / 64, sizeof(uint64_t), "the PCS"));
    MarkAll(triangles, pcs, candidates, ofImage, threads, report);
    QC_TRY(ListTriangles(triangles, report));
    if (def->sets && ofImage)
        QC_TRY(ListSets(pcs, report));
    return def->candidates ? ListCandidates(triangles, candidates, report) : qc_statusOk;
}

void qcPcsReport_Free(qcPcsReport* report)
{
    qcArray_Free(&report->triangles);
    qcArray_Free(&report->sets);
    qcArray_Free(&report->pairs);
    qcArray_Free(&report->bits);
    qcArray_Free(&report->groups);
    qcArray_Free(&report->items);
    qcArray_Free(&report->scratch);
}
