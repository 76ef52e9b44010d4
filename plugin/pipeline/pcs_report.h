// The PCS as the result reports it.
#ifndef QC_PIPELINE_PCS_REPORT_H
#define QC_PIPELINE_PCS_REPORT_H

#include "sweep/candidates.h"

typedef struct qcPcsReport
{
    qcArray triangles; ///< of qcTriangleRef, sorted
    qcArray bits;      ///< scratch: a bit a triangle, since most triangles of most scenes are not in the PCS
} qcPcsReport;

/// With an image: the triangles left by culling. Otherwise: the triangles of candidate pairs.
qcStatus qcPcsReport_Fill(const qcStepTriangles* triangles, const qcPcs* pcs, const qcCandidates* candidates,
                          bool ofImage, qcPcsReport* report);
void qcPcsReport_Free(qcPcsReport* report);

#endif
