// Opens and names a device.
#include "common/device.h"

#include <stdio.h>

qcExitStatus qcToolDevice_Open(const qcDeviceDef* def, qcDevice** device, qcDeviceInfo* info, qcMessage* message)
{
    qcStatus status = qcDevice_Create(def, device);
    if (status == qc_statusOk)
        status = qcDevice_GetInfo(*device, info);
    if (status == qc_statusOk)
        return qc_exitDone;
    qcMessage_Fail(message, "%s", qcLastMessage());
    return status == qc_statusDevice ? qc_exitDevice : qc_exitFailed;
}

void qcToolDevice_Print(const qcDeviceInfo* info)
{
    printf("device: %s%s%s\n", info->name, info->renderer[0] != 0 ? ", " : "", info->renderer);
}
