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
    return qc_statusOk;
}

void qcPcs_ResetTriangles(uint32_t first, uint32_t end, qcPcs* pcs)
{
    if (first != end)
        memset(&QC_AT(uint8_t, pcs->triangleSets, first), qcPcs_Pack(qc_setBfv, qc_setBfv), end - first);
}

void qcPcs_Free(qcPcs* pcs)
{
    qcArray_Free(&pcs->bodySets);
    qcArray_Free(&pcs->triangleSets);
}
