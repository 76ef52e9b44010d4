// Marks of global triangle indices, in two levels so that empty parts cost nothing, then lists.
#include "pipeline/pcs_report.h"

#include "base/status.h"

#include <string.h>

enum
{
    qc_groupSize = 64,
    qc_groupsOfWord = 8
};

/// By value, so that no mark can change a pointer.
typedef struct Marks
{
    uint8_t *triangles, *groups; ///< 1: marked
    uint64_t* bits;              ///< by group: a bit a triangle, once they are made of the marks
    size_t groupCount;           ///< a multiple of qc_groupsOfWord
} Marks;

static void Mark(Marks marks, uint32_t triangle)
{
    // Bytes: to set a bit takes a read, which waits for the write of the mark before it.
    marks.triangles[triangle] = 1;
    marks.groups[triangle / qc_groupSize] = 1;
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

/// Eight bytes, the first the lowest.
static uint64_t WordOf(const uint8_t* bytes)
{
    uint64_t word = 0;
    for (int i = 0; i < 8; i++)
        word |= (uint64_t)bytes[i] << 8 * i;
    return word;
}

/// A bit for each of eight marks. They are the lowest bits of their bytes: the product's highest byte has them side by
/// side, and nothing is carried into it.
static uint64_t BitsOf(const uint8_t* marks)
{
    return WordOf(marks) * UINT64_C(0x0102040810204080) >> 56;
}

/// Takes the lowest bit of a word that is not 0.
static uint32_t TakeBit(uint64_t* word)
{
    uint32_t bit = (uint32_t)__builtin_ctzll(*word);
    *word &= *word - 1;
    return bit;
}

/// Makes bits of the marks of triangles, and clears these. Returns the number of marked triangles.
static size_t MakeBits(Marks marks)
{
    size_t count = 0;
    for (size_t first = 0; first < marks.groupCount; first += qc_groupsOfWord)
        for (uint64_t groups = BitsOf(marks.groups + first); groups != 0;)
        {
            size_t g = first + TakeBit(&groups);
            uint8_t* ofGroup = marks.triangles + qc_groupSize * g;
            uint64_t bits = 0;
            for (int i = 0; i < qc_groupSize; i += 8)
                bits |= BitsOf(ofGroup + i) << i;
            memset(ofGroup, 0, qc_groupSize);
            marks.bits[g] = bits;
            count += (size_t)__builtin_popcountll(bits);
        }
    return count;
}

/// Lists the triangles of the bits, and clears the marks of groups.
static void ListBits(const qcStepTriangles* triangles, Marks marks, qcTriangleRef* list)
{
    uint32_t body = 0, first = 0, end = 0, slot = 0;
    for (size_t word = 0; word < marks.groupCount; word += qc_groupsOfWord)
    {
        for (uint64_t groups = BitsOf(marks.groups + word); groups != 0;)
        {
            size_t g = word + TakeBit(&groups);
            for (uint64_t left = marks.bits[g]; left != 0;)
            {
                uint32_t triangle = (uint32_t)(qc_groupSize * g) + TakeBit(&left);
                for (; triangle >= end; body++)
                {
                    first = qcStepTriangles_First(triangles, body);
                    end = qcStepTriangles_First(triangles, body + 1);
                    slot = qcStepTriangles_Slot(triangles, body);
                }
                *list++ = (qcTriangleRef){slot, triangle - first};
            }
        }
        memset(marks.groups + word, 0, qc_groupsOfWord);
    }
}

static qcStatus ListTriangles(const qcStepTriangles* triangles, Marks marks, qcPcsReport* report)
{
    size_t count = MakeBits(marks);
    qcStatus status = qcArray_Resize(&report->triangles, count, sizeof(qcTriangleRef), "the PCS");
    if (status == qc_statusOk)
        ListBits(triangles, marks, report->triangles.data);
    else
        report->groups.count = 0; // the next step clears them
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
    size_t ofWord = (size_t)qc_groupSize * qc_groupsOfWord;
    size_t groups = (triangles->count + ofWord - 1) / ofWord * qc_groupsOfWord;
    report->sets.count = report->pairs.count = 0;
    QC_TRY(qcArray_GrowZeroed(&report->marks, groups * qc_groupSize, 1, "the PCS"));
    QC_TRY(qcArray_GrowZeroed(&report->groups, groups, 1, "the PCS"));
    QC_TRY(qcArray_Resize(&report->bits, groups, sizeof(uint64_t), "the PCS"));
    const Marks marks = {report->marks.data, report->groups.data, report->bits.data, groups};
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
    qcArray_Free(&report->marks);
    qcArray_Free(&report->bits);
    qcArray_Free(&report->groups);
    qcArray_Free(&report->items);
    qcArray_Free(&report->scratch);
}
