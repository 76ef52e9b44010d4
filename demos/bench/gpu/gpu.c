// `layers` on a GL device beside `sweep`: lists of pairs compared, time of a step, time of each part of it.
#include "bench/gpu/gpu.h"

#include "common/files.h"

#include <stdlib.h>

static qcBenchExit MeasureScene(const qcGpuOptions* options, const qcGpuDevice* device, int scene, qcGpuTable* table,
                                qcMessage* message)
{
    for (uint32_t size = 0; size < qcGpuScene_CountSizes(scene, options); ++size)
    {
        if (!qcGpu_Measure(options, device, scene, size, &table->rows[table->rowCount], message))
            return qc_benchBroken;
        ++table->rowCount;
        // What a long run has is kept if it ends early.
        if (!qcGpu_WriteFiles(options, device, table, message))
            return qc_benchBroken;
    }
    qcGpu_WriteScene(stdout, table, scene);
    fflush(stdout);
    return qc_benchDone;
}

/// `layers` must have answered, and as `sweep` does. The worse is reported.
static qcBenchExit CheckRows(const qcGpuTable* table, qcMessage* message)
{
    qcBenchExit ending = qc_benchDone;
    for (uint32_t i = 0; i < table->rowCount; ++i)
    {
        const qcGpuRow* row = &table->rows[i];
        if (!qcGpuRow_Agrees(row))
        {
            qcMessage_Fail(message, "%s, %u triangles: layers and sweep find different pairs",
                           qcGpuScene_Name(row->scene), row->triangles);
            return qc_benchBroken;
        }
        if (row->failure[0] == 0 || ending != qc_benchDone)
            continue;
        qcMessage_Fail(message, "%s, %u triangles: %s", qcGpuScene_Name(row->scene), row->triangles, row->failure);
        ending = qc_benchDevice;
    }
    return ending;
}

static qcBenchExit Measure(const qcGpuOptions* options, qcGpuDevice* device, qcGpuTable* table, qcMessage* message)
{
    // Better now than after minutes of work.
    if (!qcBenchFiles_Check(options->out, "gpu.csv", message))
        return qc_benchBroken;
    qcBenchExit ending = qcGpu_OpenDevice(options, device, message);
    if (ending != qc_benchDone)
        return ending;
    qcGpu_WriteDevice(stdout, options, device);
    fflush(stdout);
    for (int scene = 0; ending == qc_benchDone && scene < qc_gpuSceneCount; ++scene)
        if (options->scenes[scene])
            ending = MeasureScene(options, device, scene, table, message);
    if (ending != qc_benchDone || table->rowCount == 0)
        return ending;
    printf("\nAll rows: %s/gpu.csv, %s/gpu_stages.csv; these tables: %s/gpu.txt\n", options->out, options->out,
           options->out);
    return CheckRows(table, message);
}

qcBenchExit qcBench_RunGpu(int argumentCount, char** arguments)
{
    qcGpuOptions options;
    qcGpuDevice device = {.device = NULL};
    qcMessage message = {""};
    qcGpu_ReadOptions(argumentCount, arguments, &options);
    qcBenchExit ending = qc_benchBroken;
    qcGpuTable* table = calloc(1, sizeof *table);
    if (table != NULL)
        ending = Measure(&options, &device, table, &message);
    else
        qcMessage_Fail(&message, "out of memory");
    if (ending != qc_benchDone)
        fprintf(stderr, "qc-bench gpu: %s\n", message.text);
    free(table);
    qcDevice_Destroy(device.device);
    return ending;
}
