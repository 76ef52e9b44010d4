// A bitmap of global triangle indices, then a list.
#include "pipeline/pcs_report.h"

#include "base/status.h"

#include <string.h>

static void Mark(uint64_t* bits, uint32_t triangle)
{
    bits[triangle / 64] |= UINT64_C(1) << triangle % 64;
}

static void MarkKey(uint64_t* bits, uint64_t key)
{
    Mark(bits, (uint32_t)(key >> 32));
    Mark(bits, (uint32_t)key);
}

static void MarkAll(const qcStepTriangles* triangles, const qcPcs* pcs, const qcCandidates* candidates, bool ofImage,
                    uint64_t* bits)
{
    for (uint32_t triangle = 0; ofImage && triangle < triangles->count; triangle++)
        if (QC_AT(uint8_t, pcs->triangleSets, triangle) != 0)
            Mark(bits, triangle);
    const uint64_t* keys = candidates->keys.data;
    for (size_t i = 0; !ofImage && i < candidates->keys.count; i++)
        MarkKey(bits, keys[i]);
    const qcSortItem* classified = candidates->classified.data;
    for (size_t i = 0; i < candidates->classified.count; i++)
        MarkKey(bits, classified[i].key);
}

qcStatus qcPcsReport_Fill(const qcStepTriangles* triangles, const qcPcs* pcs, const qcCandidates* candidates,
                          bool ofImage, qcPcsReport* report)
{
    size_t words = ((size_t)triangles->count + 63) / 64, count = 0, at = 0;
    QC_TRY(qcArray_Resize(&report->bits, words, sizeof(uint64_t), "the PCS"));
    uint64_t* bits = report->bits.data;
    if (words != 0)
        memset(bits, 0, words * sizeof *bits);
    MarkAll(triangles, pcs, candidates, ofImage, bits);
    for (size_t w = 0; w < words; w++)
        count += bits[w] != 0 ? (size_t)__builtin_popcountll(bits[w]) : 0;
    QC_TRY(qcArray_Resize(&report->triangles, count, sizeof(qcTriangleRef), "the PCS"));
    uint32_t body = 0;
    for (size_t w = 0; w < words; w++)
        for (uint64_t left = bits[w]; left != 0; left &= left - 1)
        {
            uint32_t triangle = (uint32_t)(64 * w) + (uint32_t)__builtin_ctzll(left);
            while (triangle >= qcStepTriangles_First(triangles, body + 1))
                body++;
            QC_AT(qcTriangleRef, report->triangles, at++) = (qcTriangleRef){
                qcStepTriangles_Slot(triangles, body), triangle - qcStepTriangles_First(triangles, body)};
        }
    return qc_statusOk;
}

void qcPcsReport_Free(qcPcsReport* report)
{
    qcArray_Free(&report->triangles);
    qcArray_Free(&report->bits);
}
