// A bitmap of global triangle indices, in two levels so that empty parts cost nothing, then lists.
#include "pipeline/pcs_report.h"

#include "base/status.h"

/// The bitmaps. By value, so that no mark can change a pointer.
typedef struct Marks
{
    uint64_t *bits, *groups;
} Marks;

static void Mark(Marks marks, uint32_t triangle)
{
    uint64_t* word = &marks.bits[triangle / 64];
    if (*word == 0)
        marks.groups[triangle / 4096] |= UINT64_C(1) << triangle / 64 % 64;
    *word |= UINT64_C(1) << triangle % 64;
}

static void MarkKey(Marks marks, uint64_t key)
{
    Mark(marks, (uint32_t)(key >> 32));
    Mark(marks, (uint32_t)key);
}

static void MarkAll(const qcStepTriangles* triangles, const qcPcs* pcs, const qcCandidates* candidates, bool ofImage,
                    Marks marks)
{
    for (uint32_t triangle = 0; ofImage && triangle < triangles->count; triangle++)
        if (QC_AT(uint8_t, pcs->triangleSets, triangle) != 0)
            Mark(marks, triangle);
    const uint64_t *keys = candidates->keys.data, *classified = candidates->classified.data;
    size_t keyCount = ofImage ? 0 : candidates->keys.count, classifiedCount = candidates->classified.count;
    for (size_t i = 0; i < keyCount; i++)
        MarkKey(marks, keys[i]);
    for (size_t i = 0; i < classifiedCount; i++)
        MarkKey(marks, qcRelatedPair_Key(classified[i]));
}

/// Takes the lowest bit of a word that is not 0.
static uint32_t TakeBit(uint64_t* word)
{
    uint32_t bit = (uint32_t)__builtin_ctzll(*word);
    *word &= *word - 1;
    return bit;
}

static size_t CountMarked(Marks marks, size_t groupCount)
{
    size_t count = 0;
    for (size_t g = 0; g < groupCount; g++)
        for (uint64_t words = marks.groups[g]; words != 0;)
            count += (size_t)__builtin_popcountll(marks.bits[64 * g + TakeBit(&words)]);
    return count;
}

/// Lists the marked triangles, and clears the marks.
static void TakeMarked(const qcStepTriangles* triangles, Marks marks, size_t groupCount, qcTriangleRef* list)
{
    uint32_t body = 0, first = 0, end = 0, slot = 0;
    for (size_t g = 0; g < groupCount; g++)
    {
        for (uint64_t words = marks.groups[g]; words != 0;)
        {
            size_t w = 64 * g + TakeBit(&words);
            for (uint64_t left = marks.bits[w]; left != 0;)
            {
                uint32_t triangle = (uint32_t)(64 * w) + TakeBit(&left);
                for (; triangle >= end; body++)
                {
                    first = qcStepTriangles_First(triangles, body);
                    end = qcStepTriangles_First(triangles, body + 1);
                    slot = qcStepTriangles_Slot(triangles, body);
                }
                *list++ = (qcTriangleRef){slot, triangle - first};
            }
            marks.bits[w] = 0;
        }
        marks.groups[g] = 0;
    }
}

static qcStatus ListTriangles(const qcStepTriangles* triangles, Marks marks, qcPcsReport* report)
{
    size_t groups = report->groups.count, count = CountMarked(marks, groups);
    qcStatus status = qcArray_Resize(&report->triangles, count, sizeof(qcTriangleRef), "the PCS");
    if (status == qc_statusOk)
        TakeMarked(triangles, marks, groups, report->triangles.data);
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
                          bool ofImage, const qcDetectDef* def, qcPcsReport* report)
{
    size_t words = ((size_t)triangles->count + 63) / 64;
    report->sets.count = report->pairs.count = 0;
    QC_TRY(qcArray_GrowZeroed(&report->bits, words, sizeof(uint64_t), "the PCS"));
    QC_TRY(qcArray_GrowZeroed(&report->groups, (words + 63) / 64, sizeof(uint64_t), "the PCS"));
    Marks marks = {report->bits.data, report->groups.data};
    MarkAll(triangles, pcs, candidates, ofImage, marks);
    QC_TRY(ListTriangles(triangles, marks, report));
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
