// A device inside the library: one GL context on one thread, and jobs that run there.
#ifndef QC_GL_DEVICE_H
#define QC_GL_DEVICE_H

#include "plan/costs.h"
#include "quickcullide/device.h"

struct qcGlFunctions;

/// A job; it runs on the device's thread, with the device's context current. GL's bindings and switches have their
/// initial values, and the job need not restore them. qcDevice_Run returns its status and message.
typedef qcStatus qcDeviceJob(const struct qcGlFunctions* gl, void* context);

/// Runs a job and waits for it. Any thread. Jobs of one device run one after another. qc_statusDevice: the device has
/// no GL, or this is a child process forked after the device was opened, or the job caused a GL error; the message
/// names it and `purpose`. qc_statusDeviceLost: the context is lost.
qcStatus qcDevice_Run(qcDevice* device, qcDeviceJob* job, void* context, const char* purpose);

/// Any context of a device.
#define QC_ANY_GENERATION 0

/// qcDevice_Run for a job with objects of this generation: qc_statusDeviceLost if the device has another by now, for a
/// lost device is opened again in the background.
qcStatus qcDevice_RunIn(qcDevice* device, uint32_t generation, qcDeviceJob* job, void* context, const char* purpose);

/// Keeps the device's context, even if it is lost, until qcDevice_Release: for memory that the device has mapped and
/// other threads use. On a GPU the device's thread wakes, and spins for the first job of the step for a while.
/// qc_statusDeviceLost, and nothing to release: the context is lost already.
qcStatus qcDevice_Hold(qcDevice* device, const char* purpose);
void qcDevice_Release(qcDevice* device);

/// Whether the device was opened with a context of the host's to share objects with.
bool qcDevice_SharesContext(const qcDevice* device);

/// Number of contexts that the device has opened. GL objects of another generation no longer exist.
uint32_t qcDevice_GetGeneration(qcDevice* device);

/// Finds the costs measured on the device with this number of threads. False: there are none. In a child process the
/// costs are infinite. Any thread.
bool qcDevice_FindCosts(qcDevice* device, uint32_t threads, qcPlanCosts* costs);
/// Stores measured costs with the device. Any thread.
void qcDevice_KeepCosts(qcDevice* device, uint32_t threads, const qcPlanCosts* costs);

#endif
