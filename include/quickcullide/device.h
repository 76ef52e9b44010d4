/// @file
/// GL devices and pictures. A device owns one OpenGL context, on a thread of its own; the calling thread's context
/// (EGL, GLX or OSMesa) is never touched. Thread-safety: any thread may use a device; calls run one after another.
///
/// A device works in the process that opened it only. In a child process, after fork(), its calls return
/// qc_statusDevice and scenes that can do so fall back to `sweep`. qcDevice_Destroy then frees memory but not the GL
/// context. See qcDevice_Create for what such a child may open.
#ifndef QUICKCULLIDE_DEVICE_H
#define QUICKCULLIDE_DEVICE_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How a device opens GL.
typedef enum qcDeviceKind
{
    /// The first of the four kinds below that works on this machine. Never fails, since `none` always works. If
    /// GALLIUM_DRIVER or MESA_LOADER_DRIVER_OVERRIDE in the environment names one of Mesa's drivers, surfaceless is
    /// tried before OSMesa.
    qc_deviceAuto = 0,
    /// A hardware GPU, through EGL's device platform: no window system needed.
    qc_deviceEgl = 1,
    /// Software GL in memory. libOSMesa is opened at run time. Fails if GALLIUM_DRIVER in the environment is neither
    /// llvmpipe nor softpipe, since libOSMesa crashes with other drivers.
    qc_deviceOsmesa = 2,
    /// Any GL, typically software, through EGL's surfaceless platform.
    qc_deviceSurfaceless = 3,
    /// No GL: every query is answered on the CPU.
    qc_deviceNone = 4
} qcDeviceKind;

/// A GL device.
typedef struct qcDevice qcDevice;

/// How to open a device. Make it with qcDefaultDeviceDef.
///
/// For kind egl, gpuIndex, gpuName and gpuUuid select the GPU: the first that matches all of those given. If none is
/// given, it is the first hardware GPU that works; otherwise it may also be one that draws in software. Texts and bytes
/// are copied.
typedef struct qcDeviceDef
{
    uint32_t structSize; ///< sizeof(qcDeviceDef)
    qcDeviceKind kind;   ///< qc_deviceAuto by default
    int32_t gpuIndex;    ///< number in EGL's list of devices, from 0; -1, the default: any
    /// Part of the GPU's GL_RENDERER, at most 127 bytes, such as "RTX 4090". Null or empty: any.
    const char* gpuName;
    const uint8_t* gpuUuid; ///< 16 bytes, as qcDeviceInfo::uuid; null: any
    /// An OpenGL context of the host's to share objects with: see buffers.h. An EGLContext, with its
    /// EGLDisplay in shareDisplay (any platform; EGL_KHR_surfaceless_context is required), for the kinds auto, egl and
    /// surfaceless; or an OSMesaContext, with a null shareDisplay, for auto and osmesa. The host must use the same
    /// library, libEGL.so.1 or libOSMesa. Null, the default: the device shares nothing.
    ///
    /// The host's context is never made current by the library, and may stay current on the host's thread. It must
    /// exist while the device opens, and during qcDevice_Reopen. No GPU may be selected beside it. A context that
    /// reports resets (EGL_LOSE_CONTEXT_ON_RESET) is recommended: contexts that share have the same strategy, and
    /// without it a loss is noticed late or never.
    void* shareContext;
    void* shareDisplay; ///< the EGLDisplay of shareContext; null for an OSMesaContext
    /// A lost device is opened again by itself: seconds from the loss to the first attempt. Each failure, and each loss
    /// that soon follows, doubles the pause, up to 64 times the first. Attempts begin with a call that uses the device
    /// and take place on its thread, while scenes are answered by the CPU and other calls return qc_statusDeviceLost.
    /// Only the same GPU and driver are taken, and never with shareContext. 0, the default: 5 seconds; below 0: only
    /// qcDevice_Reopen opens the device again.
    double reopenSeconds;
    /// Folder for binaries of the driver's compiler, which make later starts quicker; at most 1023 bytes. It is made at
    /// the first use, and may be deleted at any time. Binaries of other drivers, damaged files and full disks do no
    /// harm: programs are compiled. Null, the default: the environment's QC_PROGRAM_CACHE (nothing is stored if that is
    /// no absolute path), or else quickcullide in XDG_CACHE_HOME or in ~/.cache. Empty: nothing is stored.
    const char* cacheFolder;
} qcDeviceDef;

/// The default definition: kind auto, any GPU, no sharing.
static inline qcDeviceDef qcDefaultDeviceDef(void)
{
    qcDeviceDef def;
    def.structSize = (uint32_t)sizeof(qcDeviceDef);
    def.kind = qc_deviceAuto;
    def.gpuIndex = -1;
    def.gpuName = NULL;
    def.gpuUuid = NULL;
    def.shareContext = NULL;
    def.shareDisplay = NULL;
    def.reopenSeconds = 0.0;
    def.cacheFolder = NULL;
    return def;
}

/// The properties of an open device. Strings are valid until qcDevice_Reopen or qcDevice_Destroy.
typedef struct qcDeviceInfo
{
    qcDeviceKind kind;      ///< the kind that was opened; never qc_deviceAuto
    const char* name;       ///< "egl", "osmesa", "surfaceless" or "none"
    const char* renderer;   ///< GL_RENDERER; empty for none
    const char* version;    ///< GL_VERSION; empty for none
    const char* vendor;     ///< GL_VENDOR; empty for none
    uint32_t maxResolution; ///< pixels on a side of the largest square image; 0 for none
    bool software;          ///< the renderer runs on the CPU
    bool compute;           ///< compute shaders (GL 4.3), which the method `layers` requires
    /// The GL context is lost: calls that need it return qc_statusDeviceLost until the device is reopened (see
    /// qcDeviceDef::reopenSeconds), and the methods auto and `layers` run on the CPU.
    bool lost;
    uint8_t uuid[16]; ///< GL_DEVICE_UUID_EXT, equal to Vulkan's and CUDA's UUID of the GPU; zeros: not reported
} qcDeviceInfo;

/// Opens a device. Takes milliseconds up to a second, for drivers and shaders. qc_statusBadInput: a pointer is null, or
/// a field of the definition is invalid. qc_statusDevice: the kind or GPU does not work here; the message gives the
/// reason, for kind egl that of each GPU. qc_statusOutOfMemory.
///
/// A child of a process that has opened GL through this library can open qc_deviceNone only. Mesa's exit handlers crash
/// in a child of a process that has opened OSMesa: such a child must end with _exit() or exec.
QC_API qcStatus qcDevice_Create(const qcDeviceDef* def, qcDevice** device);

/// Closes a device. Destroy the scenes that use it first. Null is allowed. In exit handlers and destructors of static
/// objects, too: once the process ends, no function of GL is called, and what needs the device returns
/// qc_statusDeviceLost.
QC_API void qcDevice_Destroy(qcDevice* device);

/// Fills `info` with the device's properties. O(1). qc_statusBadInput: a pointer is null.
QC_API qcStatus qcDevice_GetInfo(const qcDevice* device, qcDeviceInfo* info);

/// Closes the GL context, lost or not, and opens a new one by the same definition; a device of kind auto keeps the kind
/// that it had opened. Scenes that use the device stay valid and upload their data in their next step. Meanwhile no
/// other call may use the device or its scenes. Takes as long as qcDevice_Create. Does nothing for kind none.
/// qc_statusDevice: no context can be opened now; the device stays lost and you may try again.
QC_API qcStatus qcDevice_Reopen(qcDevice* device);

/// One coloured triangle soup in a picture.
typedef struct qcPictureMesh
{
    const float* positions;  ///< `vertexCount` positions of three floats, tightly packed
    uint32_t vertexCount;    ///< number of vertices
    const uint32_t* indices; ///< 3 * `triangleCount` indices below `vertexCount`
    uint32_t triangleCount;  ///< number of triangles
    float color[3];          ///< of front faces (counterclockwise), linear RGB in 0..1
    float backColor[3];      ///< of back faces, linear RGB in 0..1
    /// `triangleCount` flags, or null. A triangle with a nonzero flag is drawn in `markColor`.
    const uint8_t* marked;
    float markColor[3]; ///< of marked triangles, linear RGB in 0..1
    bool smooth;        ///< shade with normals averaged around each vertex; otherwise flat
    bool wireframe;     ///< draw the triangles' edges as thin darker lines
} qcPictureMesh;

/// A perspective picture of meshes over a plain background, lit by a light with soft shadows and by the sky with
/// ambient occlusion. Make it with qcDefaultPictureDef.
typedef struct qcPictureDef
{
    uint32_t structSize;         ///< sizeof(qcPictureDef)
    uint32_t width;              ///< pixels, 1..8192
    uint32_t height;             ///< pixels, 1..8192
    float eye[3];                ///< position of the eye, in scene units
    float target[3];             ///< the point in the middle of the picture
    float up[3];                 ///< upward direction, any length but 0
    float fieldOfView;           ///< vertical, in degrees
    float background[3];         ///< linear RGB in 0..1
    const qcPictureMesh* meshes; ///< `meshCount` meshes
    uint32_t meshCount;          ///< number of meshes
    uint8_t reserved[4];         ///< 0: padding of definitions in older headers
    float light[3];              ///< direction towards the light, any length; 0: above the eye, from its left
    float groundHeight;          ///< of the ground, along `up` from the origin, in scene units
    float groundColor[3];        ///< linear RGB in 0..1
    float groundTile;            ///< width of the tiles of a chequered ground, in scene units; 0: plain
    /// Distance from `target` at which the ground has faded into the background, in scene units. 0: four pictures'
    /// heights.
    float groundExtent;
    bool hasGround;       ///< draw a ground: a plane across `up`. It is left out if the eye is below it.
    uint8_t reserved2[3]; ///< 0
} qcPictureDef;

/// The default picture: 1280 x 720 pixels, seen from (0, 0, 5) towards the origin, without meshes.
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
    for (int i = 0; i < 4; i++)
        def.reserved[i] = 0;
    for (int axis = 0; axis < 3; axis++)
    {
        def.light[axis] = 0.0f;
        def.groundColor[axis] = 0.6f;
    }
    def.groundHeight = def.groundTile = def.groundExtent = 0.0f;
    def.hasGround = false;
    for (int i = 0; i < 3; i++)
        def.reserved2[i] = 0;
    return def;
}

/// Draws an antialiased picture into `rgb`: width * height * 3 bytes, sRGB, top row first. Returns when it is there.
/// O(triangles + pixels): meshes are uploaded and drawn three times, and once more for each tile of 2048 x 2048 pixels
/// beyond the first.
///
/// qc_statusBadInput: a pointer is null, or a size, an index or a number of the definition is out of its range.
/// qc_statusDevice: the device is of kind none, or failed. qc_statusDeviceLost. qc_statusOutOfMemory.
QC_API qcStatus qcDevice_DrawPicture(qcDevice* device, const qcPictureDef* def, uint8_t* rgb);

#ifdef __cplusplus
}
#endif

#endif
