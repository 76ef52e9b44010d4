// The PCS and the candidates as the result reports them.
#ifndef QC_PIPELINE_PCS_REPORT_H
#define QC_PIPELINE_PCS_REPORT_H

#include "sweep/candidates.h"

typedef struct qcPcsReport
{
    qcArray triangles; ///< of qcTriangleRef, sorted
    qcArray sets;      ///< of qcTriangleSets, one for each triangle; empty unless requested
    qcArray pairs;     ///< of qcCandidate, sorted; empty unless requested
    //  Scratch.
    qcArray marks, groups; ///< uint8_t: of triangles and of each 64 of them; all 0 between steps
    qcArray bits;          ///< uint64_t, by group
    qcArray items, scratch;
} qcPcsReport;

/// With an image: the triangles left by culling, and their sets if `def` requests them. Otherwise: the triangles of
/// candidate pairs. In both cases the candidate pairs if `def` requests them.
qcStatus qcPcsReport_Fill(const qcStepTriangles* triangles, const qcPcs* pcs, const qcCandidates* candidates,
                          bool ofImage, const qcDetectDef* def, qcPcsReport* report);
void qcPcsReport_Free(qcPcsReport* report);

#endif
