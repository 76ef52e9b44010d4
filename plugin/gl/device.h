// A device inside the library: one GL context on one thread, and jobs that run there.
#ifndef QC_GL_DEVICE_H
#define QC_GL_DEVICE_H

#include "plan/costs.h"
#include "quickcullide/device.h"

struct qcGlFunctions;

/// A job; it runs on the device's thread, with the device's context current and its function table.
/// It finds GL's initial bindings and switches, and may leave them as it likes.
/// Its return value, and the message it left, reach the caller of qcDevice_Run.
typedef qcStatus qcDeviceJob(const struct qcGlFunctions* gl, void* context);

/// Runs a job and waits for it. Any thread. qc_statusDevice on a device without GL, and in a child process that was
/// forked after the device was opened; qc_statusDeviceLost on a lost one. When the job left a GL error behind,
/// qc_statusDevice, naming the error and `purpose`.
qcStatus qcDevice_Run(qcDevice* device, qcDeviceJob* job, void* context, const char* purpose);

/// How many contexts the device has opened so far: GL objects of another generation no longer exist.
uint32_t qcDevice_GetGeneration(qcDevice* device);

/// Costs that were measured on the device with as many threads are kept with it. False: there are none yet. In a child
/// process the device's costs are infinite. Any thread.
bool qcDevice_FindCosts(qcDevice* device, uint32_t threads, qcPlanCosts* costs);
void qcDevice_KeepCosts(qcDevice* device, uint32_t threads, const qcPlanCosts* costs);

#endif
