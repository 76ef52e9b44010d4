// qc-pairs: finds the triangles of meshes that intersect. Each mesh is a rigid body at the positions of its file.
#include "pairs/pairs.h"

#include "common/output_file.h"
#include "common/progress.h"

#include <stdio.h>
#include <stdlib.h>

static bool ReadMeshes(qcPairsRun* run, qcMessage* message)
{
    const qcPairsOptions* options = run->options;
    for (uint32_t i = 0; i < options->pathCount; ++i)
    {
        char label[256];
        snprintf(label, sizeof label, "reading %s", options->paths[i]);
        qcProgress_Begin(0, label);
        bool read = qcMesh_ReadFile(options->paths[i], options->f64 ? qc_meshDouble : qc_meshAsDeclared,
                                    &run->meshes[i], message);
        qcProgress_End();
        if (!read)
            return false;
    }
    return true;
}

static qcStatus OpenDevice(qcDeviceKind kind, qcDevice** device, qcDeviceInfo* info)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = kind;
    qcStatus status = qcDevice_Create(&def, device);
    return status == qc_statusOk ? qcDevice_GetInfo(*device, info) : status;
}

/// Opens a device only if this run needs one: creating a GL context takes longer than many queries.
static qcExitStatus OpenDevices(qcPairsRun* run, qcMessage* message)
{
    const qcPairsOptions* options = run->options;
    bool draws = options->detect.method == qc_methodQuick || options->detect.method == qc_methodCullide ||
                 options->detect.method == qc_methodLayers;
    qcStatus status = qc_statusOk;
    run->deviceInfo =
        (qcDeviceInfo){.kind = qc_deviceNone, .name = "none", .renderer = "", .version = "", .vendor = ""};
    if (draws || options->deviceName != NULL)
        status = OpenDevice(options->device, &run->device, &run->deviceInfo);
    if (status == qc_statusOk && options->picture != NULL)
    {
        qcDeviceInfo info = run->deviceInfo;
        run->pictureDevice = run->device;
        if (info.kind == qc_deviceNone)
        {
            run->pictureDevice = NULL;
            status = OpenDevice(qc_deviceAuto, &run->pictureDevice, &info);
        }
        if (status == qc_statusOk && info.kind == qc_deviceNone)
        {
            qcMessage_Fail(message, "--picture: no device here can draw");
            return qc_exitDevice;
        }
    }
    if (status == qc_statusOk)
        return qc_exitDone;
    qcMessage_Fail(message, "%s", qcLastMessage());
    return status == qc_statusDevice ? qc_exitDevice : qc_exitFailed;
}

static void CloseDevices(qcPairsRun* run)
{
    if (run->pictureDevice != run->device)
        qcDevice_Destroy(run->pictureDevice);
    qcDevice_Destroy(run->device);
}

static qcStatus AddMesh(qcPairsRun* run, uint32_t index, qcBodyId* id)
{
    const qcMesh* mesh = &run->meshes[index];
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = mesh->positions;
    def.positionType = mesh->isDouble ? qc_positionF64 : qc_positionF32;
    def.vertexCount = mesh->vertexCount;
    def.indices = mesh->indices;
    def.triangleCount = mesh->triangleCount;
    def.selfCollision = run->options->selfCollision;
    return qcScene_AddBody(run->scene, &def, id);
}

static int CompareTimes(const void* a, const void* b)
{
    double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

/// `times` holds `reps` numbers for each stage, one stage after another.
static void Summarize(qcPairsRun* run, double* times)
{
    static const char* names[qc_stageCount] = {"plan",           "cullObjects", "sweepObjects", "cullTriangles",
                                               "sweepTriangles", "exact",       "contact",      "total"};
    size_t reps = run->options->reps;
    for (size_t i = 0; i < qc_stageCount; ++i)
    {
        double* stage = times + i * reps;
        qsort(stage, reps, sizeof *stage, CompareTimes);
        run->stages[i] = (qcPairsStage){names[i], stage[0], 0.5 * (stage[(reps - 1) / 2] + stage[reps / 2])};
    }
    for (size_t i = 0; i < run->result->pairCount; ++i)
        ++run->relations[run->result->pairs[i].relation];
}

static qcStatus Detect(qcPairsRun* run, const qcBodyId* ids, double* times)
{
    const qcPairsOptions* options = run->options;
    qcTransform identity = qcIdentityTransform();
    for (uint32_t rep = 0; rep < options->reps; ++rep)
    {
        // A scene that has not changed would return its last result.
        for (uint32_t i = 0; rep > 0 && i < options->pathCount; ++i)
        {
            qcStatus status = qcScene_SetTransform(run->scene, ids[i], &identity);
            if (status != qc_statusOk)
                return status;
        }
        qcStatus status = qcScene_Detect(run->scene, &options->detect, &run->result);
        if (status != qc_statusOk)
            return status;
        const qcProfile* profile = &run->result->profile;
        double stages[qc_stageCount] = {profile->planMs,          profile->cullObjectsMs,    profile->sweepObjectsMs,
                                        profile->cullTrianglesMs, profile->sweepTrianglesMs, profile->exactMs,
                                        profile->contactMs,       profile->totalMs};
        for (size_t i = 0; i < qc_stageCount; ++i)
            times[i * options->reps + rep] = stages[i];
        qcProgress_Update(rep + 1);
    }
    Summarize(run, times);
    return qc_statusOk;
}

static qcStatus FillAndDetect(qcPairsRun* run, qcBodyId* ids, double* times, const char** place)
{
    const qcPairsOptions* options = run->options;
    qcSceneDef def = qcDefaultSceneDef();
    def.device = run->device;
    qcStatus status = qcScene_Create(&def, &run->scene);
    for (uint32_t i = 0; status == qc_statusOk && i < options->pathCount; ++i)
    {
        status = AddMesh(run, i, &ids[i]);
        if (status != qc_statusOk)
            *place = options->paths[i];
    }
    if (status != qc_statusOk)
        return status;
    qcProgress_Begin(options->reps > 1 ? options->reps : 0, "detecting");
    status = Detect(run, ids, times);
    qcProgress_End();
    return status;
}

static qcExitStatus FindPairs(qcPairsRun* run, qcMessage* message)
{
    const qcPairsOptions* options = run->options;
    qcBodyId* ids = malloc(options->pathCount * sizeof *ids);
    double* times = malloc((size_t)options->reps * qc_stageCount * sizeof *times);
    qcExitStatus ending = qc_exitDone;
    const char* place = "detecting";
    if (ids == NULL || times == NULL)
    {
        qcMessage_Fail(message, "out of memory");
        ending = qc_exitFailed;
    }
    else
    {
        qcStatus status = FillAndDetect(run, ids, times, &place);
        if (status != qc_statusOk)
        {
            qcMessage_Fail(message, "%s: %s", place, qcLastMessage());
            bool device = status == qc_statusDevice || status == qc_statusDeviceLost;
            ending = device ? qc_exitDevice : status == qc_statusBadInput ? qc_exitBadInput : qc_exitFailed;
        }
    }
    free(times);
    free(ids);
    return ending;
}

static qcExitStatus WriteResults(const qcPairsRun* run, qcMessage* message)
{
    const qcPairsOptions* options = run->options;
    if ((options->out != NULL || options->pairsOnOutput) && !qcPairs_WritePairs(run, message))
        return qc_exitFailed;
    if (options->picture != NULL)
    {
        qcProgress_Begin(0, "drawing");
        qcExitStatus ending = qcPairs_DrawPicture(run, message);
        qcProgress_End();
        if (ending != qc_exitDone)
            return ending;
    }
    return qcPairs_WriteReport(run, message) ? qc_exitDone : qc_exitFailed;
}

static qcExitStatus Run(qcPairsRun* run, qcMessage* message)
{
    const qcPairsOptions* options = run->options;
    // Fails here, not after minutes of work.
    if ((options->out != NULL && !qcOutput_Check(options->out, message)) ||
        (options->picture != NULL && !qcOutput_Check(options->picture, message)))
        return qc_exitFailed;
    run->meshes = calloc(options->pathCount, sizeof *run->meshes);
    if (run->meshes == NULL)
    {
        qcMessage_Fail(message, "out of memory");
        return qc_exitFailed;
    }
    if (!ReadMeshes(run, message))
        return qc_exitBadInput;
    qcExitStatus ending = OpenDevices(run, message);
    if (ending == qc_exitDone)
        ending = FindPairs(run, message);
    return ending == qc_exitDone ? WriteResults(run, message) : ending;
}

int main(int argumentCount, char** arguments)
{
    qcPairsOptions options;
    qcPairs_ReadOptions(argumentCount, arguments, &options);
    qcPairsRun run = {.options = &options};
    qcMessage message = {""};
    qcExitStatus ending = Run(&run, &message);
    if (ending != qc_exitDone)
        fprintf(stderr, "qc-pairs: %s\n", message.text);
    qcScene_Destroy(run.scene);
    CloseDevices(&run);
    for (uint32_t i = 0; run.meshes != NULL && i < options.pathCount; ++i)
        qcMesh_Free(&run.meshes[i]);
    free(run.meshes);
    return (int)ending;
}
