// Devices and a job for them, shared by the tests of devices.
#ifndef QC_TESTS_GL_DEVICE_JOBS_H
#define QC_TESTS_GL_DEVICE_JOBS_H

#include "support/devices.h"
#include "gl/device.h"
#include "gl/gl_functions.h"

#include <string.h>

static inline qcStatus qcOpenKind(qcDeviceKind kind, qcDevice** device)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = kind;
    return qcDevice_Create(&def, device);
}

/// Clears a small image to a colour and reads it back.
static inline qcStatus qcClearAndRead(const struct qcGlFunctions* gl, void* context)
{
    uint8_t* rgba = context;
    GLuint framebuffer = 0, color = 0;
    gl->GenFramebuffers(1, &framebuffer);
    gl->GenRenderbuffers(1, &color);
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl->BindRenderbuffer(GL_RENDERBUFFER, color);
    gl->RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, 4, 4);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color);
    gl->ClearColor((float)rgba[0] / 255.0f, (float)rgba[1] / 255.0f, (float)rgba[2] / 255.0f, 1.0f);
    gl->Clear(GL_COLOR_BUFFER_BIT);
    memset(rgba, 0, 4);
    gl->ReadPixels(1, 1, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    gl->DeleteFramebuffers(1, &framebuffer);
    gl->DeleteRenderbuffers(1, &color);
    return qc_statusOk;
}

#endif
