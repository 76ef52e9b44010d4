// The software devices of this machine, for tests that run on each.
#ifndef QC_TESTS_DEVICES_H
#define QC_TESTS_DEVICES_H

#include "quickcullide/device.h"

#include <stdio.h>

static const qcDeviceKind qc_softwareKinds[] = {qc_deviceOsmesa, qc_deviceSurfaceless};

/// Null, and a line of output, where this kind does not work.
static inline qcDevice* qcOpenOrSkip(qcDeviceKind kind)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = kind;
    qcDevice* device = NULL;
    if (qcDevice_Create(&def, &device) != qc_statusOk)
        printf("skipped: %s\n", qcLastMessage());
    return device;
}

/// Runs what follows on each software device, open as `device`.
#define QC_FOR_EACH_DEVICE(device)                                                                                     \
    for (size_t kindIndex = 0; kindIndex < 2; ++kindIndex)                                                             \
        for (qcDevice* device = qcOpenOrSkip(qc_softwareKinds[kindIndex]); device != NULL;                             \
             qcDevice_Destroy(device), device = NULL)

#endif
