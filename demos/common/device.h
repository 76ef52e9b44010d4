// The device that a tool is run on.
#ifndef QC_DEMOS_COMMON_DEVICE_H
#define QC_DEMOS_COMMON_DEVICE_H

#include "common/exit_status.h"
#include "common/message.h"

#include "quickcullide/device.h"

/// Opens a device and describes it. qc_exitDevice: none like it works here; qc_exitFailed: another failure; both with a
/// message. The caller destroys the device, also after a failure.
qcExitStatus qcToolDevice_Open(const qcDeviceDef* def, qcDevice** device, qcDeviceInfo* info, qcMessage* message);

/// Prints a line on standard output: its name and its renderer.
void qcToolDevice_Print(const qcDeviceInfo* info);

#endif
