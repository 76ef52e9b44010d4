// A device draws: it owns one OpenGL context, on a thread of its own, so that the context of the
// calling thread (EGL, GLX or OSMesa) is never touched.
//
// Thread-safety: any thread may use a device; calls run one after another.
//
// Processes: a device stays in the process that opened it. In a child process, after fork(), it gives qc_statusDevice,
// methods that can fall back to the sweep do so, and qcDevice_Destroy frees its memory but not its GL context. A child
// of a process that has opened GL through this library can't open it again; qc_deviceNone it can. Mesa's own exit
// handlers crash in a child of a process that has opened OSMesa: such a child ends with _exit() or exec.
#ifndef QUICKCULLIDE_DEVICE_H
#define QUICKCULLIDE_DEVICE_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum qcDeviceKind
{
    /// The first of the following four that works here. Never fails: the last one always works. Surfaceless comes
    /// before OSMesa where GALLIUM_DRIVER or MESA_LOADER_DRIVER_OVERRIDE in the environment name one of Mesa's drivers.
    qc_deviceAuto = 0,
    /// A hardware GPU, through EGL's device platform: no window system needed.
    qc_deviceEgl = 1,
    /// Software GL in memory; libOSMesa is opened at run time. Fails where GALLIUM_DRIVER in the environment is neither
    /// llvmpipe nor softpipe: libOSMesa crashes with other drivers.
    qc_deviceOsmesa = 2,
    /// Software (or any) GL through EGL's surfaceless platform.
    qc_deviceSurfaceless = 3,
    /// No GL: every query is answered on the CPU.
    qc_deviceNone = 4
} qcDeviceKind;

typedef struct qcDevice qcDevice;

typedef struct qcDeviceDef
{
    uint32_t structSize;
    qcDeviceKind kind;
    /// Which GPU: the first that fits all of the following three. None of them given: the first hardware GPU that
    /// works; otherwise it may also be one that draws in software. For kind egl alone.
    /// Number in EGL's list of devices, from 0; -1: any.
    int32_t gpuIndex;
    /// A part of its GL_RENDERER, at most 127 bytes, such as "RTX 4090"; null or empty: any.
    const char* gpuName;
    /// 16 bytes, as qcDeviceInfo::uuid; null: any.
    const uint8_t* gpuUuid;
} qcDeviceDef;

static inline qcDeviceDef qcDefaultDeviceDef(void)
{
    qcDeviceDef def;
    def.structSize = (uint32_t)sizeof(qcDeviceDef);
    def.kind = qc_deviceAuto;
    def.gpuIndex = -1;
    def.gpuName = NULL;
    def.gpuUuid = NULL;
    return def;
}

typedef struct qcDeviceInfo
{
    /// What was opened; never qc_deviceAuto.
    qcDeviceKind kind;
    /// "egl", "osmesa", "surfaceless" or "none".
    const char* name;
    /// GL_RENDERER and GL_VERSION; empty for none. Valid until the device is reopened or destroyed.
    const char* renderer;
    const char* version;
    /// GL_VENDOR; likewise.
    const char* vendor;
    /// Pixels on a side of the largest square image; 0 for none.
    uint32_t maxResolution;
    /// The renderer runs on the CPU.
    bool software;
    /// Compute shaders (GL 4.3): what the method `layers` takes.
    bool compute;
    /// The GL context is lost: calls that need it return qc_statusDeviceLost until the device is reopened, `auto` and
    /// `layers` fall back on the CPU.
    bool lost;
    /// GL_DEVICE_UUID_EXT, which is also Vulkan's and CUDA's UUID of the GPU; all 0: the driver reports none.
    uint8_t uuid[16];
} qcDeviceInfo;

/// Opens a device. qc_statusDevice: the named kind or GPU does not work here; the message names the reason, for kind
/// egl that of each GPU.
QC_API qcStatus qcDevice_Create(const qcDeviceDef* def, qcDevice** device);

/// Closes a device after the last scene that uses it. Null is allowed.
QC_API void qcDevice_Destroy(qcDevice* device);

QC_API qcStatus qcDevice_GetInfo(const qcDevice* device, qcDeviceInfo* info);

/// Closes the GL context, lost or not, and opens one by the same definition; of `auto` the kind is kept. Scenes that
/// use the device stay valid and upload what they need in their next step. No other call may use the device meanwhile,
/// nor its scenes. On failure the device stays lost, and another attempt is allowed. Does nothing on the device `none`.
QC_API qcStatus qcDevice_Reopen(qcDevice* device);

/// One coloured triangle soup in a picture.
typedef struct qcPictureMesh
{
    /// `vertexCount` positions of three floats, tightly packed.
    const float* positions;
    uint32_t vertexCount;
    /// 3 * `triangleCount` indices.
    const uint32_t* indices;
    uint32_t triangleCount;
    /// Linear RGB in 0..1; the back of a triangle is drawn in `backColor`.
    float color[3];
    float backColor[3];
    /// `triangleCount` flags, or null: a triangle with a flag other than 0 is drawn in `markColor`.
    const uint8_t* marked;
    float markColor[3];
    /// Shade with normals averaged over the triangles around a vertex, otherwise flat.
    bool smooth;
    /// Draw the edges of the triangles as thin darker lines.
    bool wireframe;
} qcPictureMesh;

/// A perspective picture of some meshes over a plain background, lit from above the eye.
typedef struct qcPictureDef
{
    uint32_t structSize;
    uint32_t width, height; ///< pixels, 1..8192
    /// Eye, the point looked at, up direction; vertical field of view in degrees.
    float eye[3], target[3], up[3], fieldOfView;
    float background[3]; ///< linear RGB
    const qcPictureMesh* meshes;
    uint32_t meshCount;
} qcPictureDef;

static inline qcPictureDef qcDefaultPictureDef(void)
{
    qcPictureDef def;
    def.structSize = (uint32_t)sizeof(qcPictureDef);
    def.width = 1280;
    def.height = 720;
    for (int axis = 0; axis < 3; axis++)
        def.eye[axis] = def.target[axis] = def.up[axis] = 0.0f;
    def.eye[2] = 5.0f;
    def.up[1] = 1.0f;
    def.fieldOfView = 35.0f;
    def.background[0] = 0.93f;
    def.background[1] = 0.94f;
    def.background[2] = 0.95f;
    def.meshes = NULL;
    def.meshCount = 0;
    return def;
}

/// Draws a picture with antialiasing into `rgb`: width * height * 3 bytes, sRGB, top row first.
/// qc_statusDevice on the device `none`.
QC_API qcStatus qcDevice_DrawPicture(qcDevice* device, const qcPictureDef* def, uint8_t* rgb);

#ifdef __cplusplus
}
#endif

#endif
