// qc-gl-cloth: a cloth is simulated in GL buffers, and the library finds its self-collisions from these buffers. The
// vertices never leave the device: pairs come back, are written to a GL buffer, and push the cloth there.
#include "common/exit_status.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/png_file.h"
#include "common/stopwatch.h"
#include "gl_cloth/gl_cloth.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Options
{
    uint32_t side, frames;
    const char *platform, *picture;
    bool check;
    EGLenum eglPlatform;
} Options;

typedef struct Demo
{
    Options options;
    GlCloth cloth;
    qcDevice* device;
    qcDeviceBuffer *positions, *pairs;
    qcScene* scene;
    qcBodyId body;
    const qcResult* result; ///< of the last frame
    float* readBack;        ///< for a check or a picture
    uint8_t* marks;         ///< by triangle: in a pair
} Demo;

static const qcWord s_platforms[] = {
    {"device", EGL_PLATFORM_DEVICE_EXT}, {"surfaceless", EGL_PLATFORM_SURFACELESS_MESA}, {NULL, 0}};

static void Complete(const struct argp_state* state, void* context)
{
    Options* options = context;
    options->eglPlatform = (EGLenum)qcOption_ReadWord(state, "--platform", options->platform, s_platforms);
}

static void ReadOptions(int argumentCount, char** arguments, Options* options)
{
    *options = (Options){.side = 100, .frames = 90, .platform = "surfaceless"};
    const qcOption rows[] = {
        {1, "side", "N", "Vertices on a side of the cloth, 3..1000; %s by default",
         qcOption_Number(&options->side, 3, 1000)},
        {1, "frames", "N", "Frames of 1/60 s, 1..100000; %s by default", qcOption_Number(&options->frames, 1, 100000)},
        {1, "platform", "NAME",
         "Where the GL context comes from: device (EGL's first GPU) or surfaceless; %s by default",
         qcOption_Text(&options->platform)},
        {1, "check", NULL, "Read the positions back in each frame, and compare the pairs with those of the CPU",
         qcOption_Flag(&options->check, true)},
        {1, "picture", "FILE.png", "Draw the last frame, triangles in pairs in red (reads the positions back)",
         qcOption_Text(&options->picture)},
        {0},
    };
    qcCommandLine commandLine = {
        .options = rows,
        .help =
            "A cloth in GL buffers falls on a ball. Its self-collisions are found from the buffers, and push it "
            "there.\v"
            "Columns: pairs that penetrate; bytes of the cloth's positions; bytes of positions uploaded (always 0); "
            "all bytes uploaded for the detection and the pairs; bytes of positions read back (those of candidate "
            "pairs); "
            "milliseconds of the detection.\n"
            "Exit status: 0 done; 1 a check failed or the picture could not be written; 2 a mistake on the command "
            "line; 4 the device does not work here; 130 ended by Ctrl-C.",
        .complete = Complete,
        .context = options};
    qcCommandLine_Parse(&commandLine, argumentCount, arguments);
}

static qcStatus OpenBuffer(Demo* demo, GLuint name, qcDeviceBuffer** buffer)
{
    qcDeviceBufferDef def = qcDefaultDeviceBufferDef();
    def.name = name;
    return qcDevice_OpenBuffer(demo->device, &def, buffer);
}

/// A device that shares the cloth's context, and a scene with the cloth.
static qcStatus OpenScene(Demo* demo)
{
    const GlCloth* cloth = &demo->cloth;
    qcDeviceDef deviceDef = qcDefaultDeviceDef();
    deviceDef.shareDisplay = cloth->display;
    deviceDef.shareContext = cloth->context;
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcBodyDef body = qcDefaultBodyDef();
    body.positions = cloth->positions;
    body.vertexCount = cloth->vertexCount;
    body.indices = cloth->indices;
    body.triangleCount = cloth->triangleCount;
    body.deforming = true;
    qcStatus status = qcDevice_Create(&deviceDef, &demo->device);
    sceneDef.device = demo->device;
    if (status == qc_statusOk)
        status = OpenBuffer(demo, cloth->buffers[qc_clothPositions], &demo->positions);
    if (status == qc_statusOk)
        status = OpenBuffer(demo, cloth->buffers[qc_clothPairs], &demo->pairs);
    if (status == qc_statusOk)
        status = qcScene_Create(&sceneDef, &demo->scene);
    return status == qc_statusOk ? qcScene_AddBody(demo->scene, &body, &demo->body) : status;
}

/// From the cloth's buffer to pairs in the buffer of pairs.
static qcStatus Detect(Demo* demo, GLsync fence, double* ms)
{
    qcVertexBufferDef vertices = qcDefaultVertexBufferDef();
    vertices.buffer = demo->positions;
    vertices.fence = fence;
    qcDetectDef detect = qcDefaultDetectDef();
    detect.method = qc_methodLayers;
    qcPairBufferDef pairs = qcDefaultPairBufferDef();
    pairs.buffer = demo->pairs;
    pairs.capacity = demo->cloth.pairCapacity;
    double start = qcStopwatch_NowMs();
    qcStatus status = qcScene_SetVertexBuffer(demo->scene, demo->body, &vertices);
    if (status == qc_statusOk)
        status = qcScene_Detect(demo->scene, &detect, &demo->result);
    if (status == qc_statusOk)
        status = qcScene_WritePairs(demo->scene, &pairs);
    *ms = qcStopwatch_NowMs() - start;
    return status;
}

/// Compares the pairs with those of a scene without a device, on the same positions.
static bool Check(const Demo* demo)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcDetectDef detect = qcDefaultDetectDef();
    qcBodyDef body = qcDefaultBodyDef();
    qcScene* scene = NULL;
    qcBodyId id;
    const qcResult *result, *found = demo->result;
    GlCloth_Read(&demo->cloth, demo->readBack);
    body.positions = demo->readBack;
    body.vertexCount = demo->cloth.vertexCount;
    body.indices = demo->cloth.indices;
    body.triangleCount = demo->cloth.triangleCount;
    body.deforming = true;
    bool same = qcScene_Create(&sceneDef, &scene) == qc_statusOk && qcScene_AddBody(scene, &body, &id) == qc_statusOk &&
                qcScene_Detect(scene, &detect, &result) == qc_statusOk && result->pairCount == found->pairCount &&
                (found->pairCount == 0 || memcmp(result->pairs, found->pairs, sizeof(qcPair) * found->pairCount) == 0);
    qcScene_Destroy(scene);
    return same;
}

static bool RunFrame(Demo* demo, uint32_t frame, qcExitStatus* exitStatus)
{
    double ms;
    GLsync fence = GlCloth_Step(&demo->cloth);
    qcStatus status = Detect(demo, fence, &ms);
    glDeleteSync(fence);
    if (status != qc_statusOk)
    {
        fprintf(stderr, "qc-gl-cloth: %s\n", qcLastMessage());
        *exitStatus = qc_exitDevice;
        return false;
    }
    const qcProfile* profile = &demo->result->profile;
    printf("%5u %7zu %10u %9u %9llu %9llu %8.3f\n", frame, demo->result->pairCount, 12 * demo->cloth.vertexCount, 0,
           (unsigned long long)(profile->uploadedBytes + 4 + sizeof(qcPair) * demo->result->pairCount),
           (unsigned long long)profile->readBackBytes, ms);
    if (profile->fallback != NULL)
        printf("  %s\n", profile->fallback);
    if (demo->options.check && !Check(demo))
    {
        fprintf(stderr, "qc-gl-cloth: frame %u: the CPU finds other pairs in the same positions\n", frame);
        *exitStatus = qc_exitFailed;
        return false;
    }
    GlCloth_Respond(&demo->cloth);
    return true;
}

static bool DrawPicture(const Demo* demo, qcMessage* message)
{
    qcPictureDef def = qcDefaultPictureDef();
    GlCloth_Read(&demo->cloth, demo->readBack);
    for (size_t i = 0; i < demo->result->pairCount; i++)
        demo->marks[demo->result->pairs[i].triangleA] = demo->marks[demo->result->pairs[i].triangleB] = 1;
    const qcPictureMesh mesh = {.positions = demo->readBack,
                                .vertexCount = demo->cloth.vertexCount,
                                .indices = demo->cloth.indices,
                                .triangleCount = demo->cloth.triangleCount,
                                .color = {0.25f, 0.45f, 0.7f},
                                .backColor = {0.75f, 0.6f, 0.3f},
                                .marked = demo->marks,
                                .markColor = {0.8f, 0.1f, 0.05f},
                                .smooth = true};
    def.meshes = &mesh;
    def.meshCount = 1;
    def.eye[0] = 2.2f, def.eye[1] = 2.0f, def.eye[2] = 3.2f;
    def.target[1] = 0.5f;
    def.hasGround = true;
    uint8_t* rgb = malloc((size_t)def.width * def.height * 3);
    bool drawn = rgb != NULL && qcDevice_DrawPicture(demo->device, &def, rgb) == qc_statusOk;
    if (!drawn)
        qcMessage_Fail(message, "%s", rgb == NULL ? "out of memory" : qcLastMessage());
    else
        drawn = qcPng_Write(demo->options.picture, def.width, def.height, rgb, message);
    free(rgb);
    return drawn;
}

static qcExitStatus Run(Demo* demo, qcMessage* message)
{
    qcExitStatus exitStatus = qc_exitDone;
    if (demo->options.picture != NULL && !qcOutput_Check(demo->options.picture, message))
        return qc_exitFailed;
    if (!GlCloth_Open(&demo->cloth, demo->options.eglPlatform, demo->options.side, message))
        return qc_exitDevice;
    demo->readBack = malloc(3 * sizeof(float) * demo->cloth.vertexCount);
    demo->marks = calloc(demo->cloth.triangleCount, 1);
    if (demo->readBack == NULL || demo->marks == NULL || OpenScene(demo) != qc_statusOk)
    {
        qcMessage_Fail(message, "%s", demo->marks == NULL ? "out of memory" : qcLastMessage());
        return qc_exitDevice;
    }
    printf("%u triangles, %s\n", demo->cloth.triangleCount, (const char*)glGetString(GL_RENDERER));
    printf("frame   pairs  positions  uploaded   all up   read back       ms\n");
    qcInterrupt_Watch();
    for (uint32_t frame = 1; frame <= demo->options.frames && qcInterrupt_Signal() == 0; frame++)
        if (!RunFrame(demo, frame, &exitStatus))
            return exitStatus;
    if (demo->options.check)
        printf("the CPU finds the same pairs in every frame\n");
    if (demo->options.picture != NULL && demo->result != NULL && !DrawPicture(demo, message))
        return qc_exitFailed;
    return qcInterrupt_ExitStatus();
}

int main(int argumentCount, char** arguments)
{
    static Demo s_demo;
    qcMessage message = {""};
    ReadOptions(argumentCount, arguments, &s_demo.options);
    qcExitStatus status = Run(&s_demo, &message);
    if (message.text[0] != 0)
        fprintf(stderr, "qc-gl-cloth: %s\n", message.text);
    qcScene_Destroy(s_demo.scene);
    qcDeviceBuffer_Close(s_demo.positions);
    qcDeviceBuffer_Close(s_demo.pairs);
    qcDevice_Destroy(s_demo.device);
    GlCloth_Close(&s_demo.cloth);
    free(s_demo.readBack);
    free(s_demo.marks);
    return (int)status;
}
