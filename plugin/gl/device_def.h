// The definition of a device: its check, and the choices in it.
#ifndef QC_GL_DEVICE_DEF_H
#define QC_GL_DEVICE_DEF_H

#include "gl/context.h"
#include "quickcullide/device.h"

/// qc_statusBadInput, with a message: no device can be opened by this definition. `kindName`: of def->kind; null if
/// there is no such kind.
qcStatus qcDeviceDef_Check(const qcDeviceDef* def, const char* kindName);
/// The GPU, or the context to share objects with.
qcGpuChoice qcDeviceDef_Choice(const qcDeviceDef* def);
/// Milliseconds from a loss to the first attempt to reopen the device; below 0: it is not opened again.
double qcDeviceDef_ReopenPause(const qcDeviceDef* def);

#endif
