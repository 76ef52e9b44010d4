// Identity of the current context: renderer, version and UUID.
#include "gl/context.h"

#include "base/status.h"

#include <stdio.h>
#include <string.h>

static bool IsSoftwareRenderer(const char* renderer)
{
    static const char* const names[] = {"llvmpipe", "softpipe", "swrast", "Software Rasterizer", "SwiftShader"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (strstr(renderer, names[i]) != NULL)
            return true;
    return false;
}

static void ReadUuid(const qcContext* context, uint8_t uuid[16])
{
    // A function may exist for a name that the driver doesn't support.
    if (!qcGl_HasExtension(context->getFunction, "GL_EXT_memory_object"))
        return;
    PFNGLGETUNSIGNEDBYTEI_VEXTPROC getBytes =
        (PFNGLGETUNSIGNEDBYTEI_VEXTPROC)context->getFunction("glGetUnsignedBytei_vEXT");
    // Several GPUs may serve one context; the first has number 0.
    if (getBytes != NULL)
        getBytes(GL_DEVICE_UUID_EXT, 0, uuid);
}

qcStatus qcContext_Identify(const qcContext* context, qcGpuIdentity* identity)
{
    PFNGLGETSTRINGPROC getString = (PFNGLGETSTRINGPROC)context->getFunction("glGetString");
    const char* renderer = getString != NULL ? (const char*)getString(GL_RENDERER) : NULL;
    const char* version = getString != NULL ? (const char*)getString(GL_VERSION) : NULL;
    const char* vendor = getString != NULL ? (const char*)getString(GL_VENDOR) : NULL;
    if (renderer == NULL || version == NULL || vendor == NULL)
        return qcFail(qc_statusDevice, "the GL context reports no renderer");
    *identity = (qcGpuIdentity){.software = IsSoftwareRenderer(renderer)};
    snprintf(identity->renderer, sizeof identity->renderer, "%s", renderer);
    snprintf(identity->version, sizeof identity->version, "%s", version);
    snprintf(identity->vendor, sizeof identity->vendor, "%s", vendor);
    ReadUuid(context, identity->uuid);
    return qc_statusOk;
}
