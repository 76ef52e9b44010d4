// `layers` on a GL device beside `sweep`: lists of pairs compared, time of a step, time of each part of it.
#include "bench/gpu/gpu.h"

#include "common/files.h"

#include <inttypes.h>
#include <stdlib.h>

static qcExitStatus MeasureScene(const qcGpuOptions* options, const qcGpuDevice* device, int scene, qcGpuTable* table,
                                 qcMessage* message)
{
    for (uint32_t size = 0; size < qcGpuScene_CountSizes(scene, options); ++size)
    {
        qcAnimation animation;
        qcBenchMade made = qcGpuScene_Make(scene, size, options, &animation, message);
        if (made == qc_benchSkipped)
            printf("\n%s is skipped: %s\n", qcGpuScene_Name(scene), message->text);
        if (made == qc_benchFailed)
            return qc_exitFailed;
        bool measured = made == qc_benchSkipped ||
                        qcGpu_Measure(options, device, scene, &animation, &table->rows[table->rowCount], message);
        table->rowCount += made == qc_benchMade && measured;
        qcAnimation_Free(&animation);
        // Rows of a long run remain if it ends early.
        if (!measured || !qcGpu_WriteFiles(options, device, table, message))
            return qc_exitFailed;
    }
    qcGpu_WriteScene(stdout, table, scene);
    fflush(stdout);
    return qc_exitDone;
}

/// `layers` must have run and found the pairs of `sweep`. The more serious failure is reported.
static qcExitStatus CheckRows(const qcGpuTable* table, qcMessage* message)
{
    qcExitStatus ending = qc_exitDone;
    for (uint32_t i = 0; i < table->rowCount; ++i)
    {
        const qcGpuRow* row = &table->rows[i];
        if (!qcGpuRow_Agrees(row))
        {
            qcMessage_Fail(message, "%s, %u triangles: layers and sweep find different pairs",
                           qcGpuScene_Name(row->scene), row->triangles);
            return qc_exitFailed;
        }
        if (row->failure[0] == 0 || ending != qc_exitDone)
            continue;
        qcMessage_Fail(message, "%s, %u triangles: %s", qcGpuScene_Name(row->scene), row->triangles, row->failure);
        ending = qc_exitDevice;
    }
    return ending;
}

/// Fails if all scenes are larger than requested.
static bool CheckSizes(const qcGpuOptions* options, qcMessage* message)
{
    uint32_t sizes = 0;
    for (int scene = 0; scene < qc_gpuSceneCount; ++scene)
        sizes += options->scenes[scene] ? qcGpuScene_CountSizes(scene, options) : 0;
    return sizes != 0 || options->maxTriangles == 0 ||
           qcMessage_Fail(message, "none of the scenes has at most %" PRIu32 " triangles (--triangles)",
                          options->maxTriangles);
}

static qcExitStatus Measure(qcGpuOptions* options, qcGpuDevice* device, qcGpuTable* table, qcMessage* message)
{
    // Fails here, not after minutes of work.
    if (!CheckSizes(options, message) || !qcFiles_Check(options->out, "gpu.csv", message))
        return qc_exitFailed;
    qcExitStatus ending = qcGpu_OpenDevice(options, device, message);
    if (ending != qc_exitDone)
        return ending;
    if (options->maxTriangles == UINT32_MAX)
        options->maxTriangles = device->info.software ? 1000000 : 4000000;
    qcGpu_WriteDevice(stdout, options, device);
    fflush(stdout);
    for (int scene = 0; ending == qc_exitDone && scene < qc_gpuSceneCount; ++scene)
        if (options->scenes[scene])
            ending = MeasureScene(options, device, scene, table, message);
    if (ending != qc_exitDone || table->rowCount == 0)
        return ending;
    printf("\nAll rows: %s/gpu.csv, %s/gpu_stages.csv; these tables: %s/gpu.txt\n", options->out, options->out,
           options->out);
    return CheckRows(table, message);
}

qcExitStatus qcBench_RunGpu(int argumentCount, char** arguments)
{
    qcGpuOptions options;
    qcGpuDevice device = {.device = NULL};
    qcMessage message = {""};
    qcGpu_ReadOptions(argumentCount, arguments, &options);
    qcGpu_CountAllocations();
    qcExitStatus ending = qc_exitFailed;
    qcGpuTable* table = calloc(1, sizeof *table);
    if (table != NULL)
        ending = Measure(&options, &device, table, &message);
    else
        qcMessage_Fail(&message, "out of memory");
    if (ending != qc_exitDone)
        fprintf(stderr, "qc-bench gpu: %s\n", message.text);
    free(table);
    qcDevice_Destroy(device.device);
    return ending;
}
