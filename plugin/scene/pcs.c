// Memory of the sets.
#include "scene/pcs.h"

#include "base/status.h"

#include <string.h>

qcStatus qcPcs_Reset(uint32_t bodyCount, uint32_t triangleCount, qcPcs* pcs)
{
    QC_TRY(qcArray_Resize(&pcs->bodySets, bodyCount, 1, "the PCS"));
    QC_TRY(qcArray_Resize(&pcs->triangleSets, triangleCount, 1, "the PCS"));
    if (bodyCount != 0)
        memset(pcs->bodySets.data, qc_setNfv, bodyCount);
    if (triangleCount != 0)
        memset(pcs->triangleSets.data, qcPcs_Pack(qc_setBfv, qc_setBfv), triangleCount);
    return qc_statusOk;
}

void qcPcs_Free(qcPcs* pcs)
{
    qcArray_Free(&pcs->bodySets);
    qcArray_Free(&pcs->triangleSets);
}
