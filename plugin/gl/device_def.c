// What a definition selects, and which definitions are refused.
#include "gl/device_def.h"

#include "base/status.h"
#include "gl/cache_files.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// From a loss to the first attempt to reopen the device, where its definition names no time.
static const double s_reopenSeconds = 5.0;

/// The kinds that can share the context, if the definition gives one.
static qcStatus CheckShare(const qcDeviceDef* def, const char* kindName, bool gpuChosen)
{
    if (def->shareContext == NULL)
        return def->shareDisplay == NULL
                   ? qc_statusOk
                   : qcFail(qc_statusBadInput, "qcDevice_Create: def->shareDisplay without def->shareContext");
    if (gpuChosen)
        return qcFail(qc_statusBadInput, "qcDevice_Create: def->shareContext has a GPU; def must choose none");
    if (def->kind == qc_deviceNone)
        return qcFail(qc_statusBadInput, "qcDevice_Create: the device none shares no context");
    if (def->shareDisplay == NULL && def->kind != qc_deviceAuto && def->kind != qc_deviceOsmesa)
        return qcFail(qc_statusBadInput, "qcDevice_Create: def->shareContext needs def->shareDisplay for kind %s",
                      kindName);
    if (def->shareDisplay != NULL && def->kind == qc_deviceOsmesa)
        return qcFail(qc_statusBadInput, "qcDevice_Create: kind osmesa shares no context of an EGLDisplay");
    return qc_statusOk;
}

qcStatus qcDeviceDef_Check(const qcDeviceDef* def, const char* kindName)
{
    if ((unsigned)def->kind > qc_deviceNone)
        return qcFail(qc_statusBadInput, "qcDevice_Create: def->kind is %d", (int)def->kind);
    if (def->gpuIndex < -1)
        return qcFail(qc_statusBadInput, "qcDevice_Create: def->gpuIndex is %d", (int)def->gpuIndex);
    if (def->gpuName != NULL && strlen(def->gpuName) >= sizeof((qcGpuChoice*)NULL)->name)
        return qcFail(qc_statusBadInput, "qcDevice_Create: def->gpuName has %zu bytes, more than 127",
                      strlen(def->gpuName));
    bool chosen = def->gpuIndex >= 0 || (def->gpuName != NULL && def->gpuName[0] != 0) || def->gpuUuid != NULL;
    if (isnan(def->reopenSeconds))
        return qcFail(qc_statusBadInput, "qcDevice_Create: def->reopenSeconds is not a number");
    if (def->cacheFolder != NULL && strlen(def->cacheFolder) >= qc_maxCacheFolder)
        return qcFail(qc_statusBadInput, "qcDevice_Create: def->cacheFolder has %zu bytes, more than %d",
                      strlen(def->cacheFolder), qc_maxCacheFolder - 1);
    if (chosen && def->kind != qc_deviceEgl)
        return qcFail(qc_statusBadInput,
                      "qcDevice_Create: gpuIndex, gpuName and gpuUuid select a GPU for kind egl only; def->kind is %s",
                      kindName);
    return CheckShare(def, kindName, chosen);
}

qcGpuChoice qcDeviceDef_Choice(const qcDeviceDef* def)
{
    qcGpuChoice choice = {.index = def->gpuIndex,
                          .hasUuid = def->gpuUuid != NULL,
                          .shareDisplay = def->shareDisplay,
                          .shareContext = def->shareContext};
    if (def->gpuName != NULL)
        snprintf(choice.name, sizeof choice.name, "%s", def->gpuName);
    if (def->gpuUuid != NULL)
        memcpy(choice.uuid, def->gpuUuid, sizeof choice.uuid);
    return choice;
}

double qcDeviceDef_ReopenPause(const qcDeviceDef* def)
{
    // A context of the host's may be gone by then.
    if (def->shareContext != NULL)
        return -1.0;
    return 1000.0 * (def->reopenSeconds != 0.0 ? def->reopenSeconds : s_reopenSeconds);
}
