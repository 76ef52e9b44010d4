// Projected overlaps of pairs, and their lists. (The corners: manifold/overlap_kernels.inl.h.)
#include "manifold/overlap_kernels.h"
#include "base/status.h"

#include <math.h>

int qcProjectedOverlap_FindCorners(const qcOverlapKernels* kernels, const qcManifoldPair* pair, qcVector direction,
                                   qcRawPoint corners[qc_maxOverlapCorners])
{
    qcTriangleView views[2];
    for (int side = 0; side < 2; side++)
        qcTriangleView_Begin(&views[side], pair->side[side]);
    return kernels->findOverlap(pair, direction, (qcTriangleView* [2]){&views[0], &views[1]}, corners);
}

void qcProjectedOverlap_Compute(const qcOverlapKernels* kernels, const qcManifoldPair* pair, qcVector direction,
                                qcProjectedOverlap* overlap)
{
    if (overlap->count >= 0)
        return;
    overlap->count = qcProjectedOverlap_FindCorners(kernels, pair, direction, overlap->corners);
    overlap->low = INFINITY;
    overlap->high = -INFINITY;
    for (int i = 0; i < overlap->count; i++)
    {
        double distance = overlap->corners[i].distance;
        overlap->low = distance < overlap->low ? distance : overlap->low;
        overlap->high = distance > overlap->high ? distance : overlap->high;
    }
}

bool qcProjectedOverlap_IsArea(const qcManifoldPair* pair, const qcRawPoint* corners, int count)
{
    qcVector longest = {0.0, 0.0, 0.0};
    for (int i = 1; i < count; i++)
    {
        qcVector d = qcMinus(corners[i].end[0], corners[0].end[0]);
        longest = qcDot(d, d) > qcDot(longest, longest) ? d : longest;
    }
    double width = QC_MANIFOLD_AREA * qcManifoldPair_SmallerSize(pair), length2 = qcDot(longest, longest);
    for (int i = 1; i < count; i++)
    {
        qcVector across = qcCross(longest, qcMinus(corners[i].end[0], corners[0].end[0]));
        if (qcDot(across, across) > width * width * length2)
            return true;
    }
    return false;
}

qcStatus qcPairOverlaps_Begin(uint32_t threads, qcPairOverlaps* overlaps)
{
    QC_TRY(qcWorkerResults_Begin(&overlaps->workers, threads, sizeof(qcOverlapWorker), "contact points"));
    for (uint32_t i = 0; i < overlaps->workers.count; i++)
        qcPairOverlaps_Worker(overlaps, i)->corners.count = 0;
    return qc_statusOk;
}

bool qcPairOverlaps_Reserve(qcPairOverlaps* overlaps, uint32_t worker, size_t count)
{
    qcOverlapWorker* self = qcPairOverlaps_Worker(overlaps, worker);
    if (!qcWorkerResult_IsOk(&self->result))
        return false;
    count += self->corners.count;
    return qcWorkerResult_Add(&self->result,
                              qcArray_Reserve(&self->corners, count, sizeof(qcRawPoint), "contact points"));
}

qcStatus qcPairOverlaps_Status(const qcPairOverlaps* overlaps)
{
    return qcWorkerResults_End(&overlaps->workers, sizeof(qcOverlapWorker));
}

void qcPairOverlaps_Set(qcPairOverlaps* overlaps, uint32_t pair, uint32_t worker, const qcProjectedOverlap* overlap,
                        qcVector normal, bool opposite, double limit)
{
    qcArray* corners = &qcPairOverlaps_Worker(overlaps, worker)->corners;
    qcCornerRange* range = &QC_AT(qcCornerRange, overlaps->ranges, pair);
    *range = (qcCornerRange){corners->count, (uint16_t)worker, 0};
    for (int i = 0; i < overlap->count; i++)
    {
        double distance = opposite ? -overlap->corners[i].distance : overlap->corners[i].distance;
        if (!(distance <= limit))
            continue;
        qcRawPoint* point = &QC_AT(qcRawPoint, *corners, corners->count++);
        *point = overlap->corners[i];
        point->normal = normal;
        point->distance = distance;
        point->pair = pair;
        range->count++;
    }
}

void qcPairOverlaps_Free(qcPairOverlaps* overlaps)
{
    for (uint32_t i = 0; i < overlaps->workers.count; i++)
    {
        qcArray_Free(&qcPairOverlaps_Worker(overlaps, i)->corners);
        qcArray_Free(&qcPairOverlaps_Worker(overlaps, i)->views);
    }
    qcArray_Free(&overlaps->workers);
    qcArray_Free(&overlaps->ranges);
}
