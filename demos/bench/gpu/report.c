// The results of the device: tables for a reader, and two CSVs.
#include "bench/gpu/gpu.h"

#include "common/files.h"

#include <inttypes.h>
#include <string.h>

//  ---- for a reader --------------------------------------------------------------------------------

void qcGpu_WriteDevice(FILE* stream, const qcGpuOptions* options, const qcGpuDevice* device)
{
    const qcDeviceInfo* info = &device->info;
    fprintf(stream, "device: %s%s\n", info->name, info->software ? ", software" : "");
    fprintf(stream, "vendor: %s\nrenderer: %s\nversion: %s\n", info->vendor, info->renderer, info->version);
    fprintf(stream, "processor: %s, %" PRIu32 " threads\n", device->processor[0] != 0 ? device->processor : "unknown",
            options->threads);
    fprintf(stream, "opened in %.0f ms; first step %.0f ms, kernels are compiled in it\n", device->openMs,
            device->firstStepMs);
    if (!info->software)
        return;
    fprintf(stream,
            "\n*** THIS IS NO GPU. %s draws on the processor: these times are none of a GPU's. ***\n"
            "*** Its timestamps are the processor's own, and taken late by some drivers (OSMesa). ***\n",
            info->renderer);
    if (device->noGpu[0] != 0)
        fprintf(stream, "*** No GPU: %s ***\n", device->noGpu);
}

static void WriteRuns(FILE* stream, const qcGpuRow* row)
{
    fprintf(stream, "%9" PRIu32, row->triangles);
    for (uint32_t i = 0; i < row->runCount; ++i)
        fprintf(stream, " %11.3f", row->runs[i].ms);
    const qcGpuRun *layers = &row->runs[0], *automatic = &row->runs[1], *sweep = &row->runs[row->runCount - 1];
    double better = layers->ms < sweep->ms ? layers->ms : sweep->ms;
    fprintf(stream, " %9.2f %13.2f %9" PRIu64 "  %016" PRIx64 "  %s\n", layers->ms > 0.0 ? sweep->ms / layers->ms : 0.0,
            better > 0.0 ? automatic->ms / better : 0.0, layers->pairs, layers->hashes[0],
            row->failure[0] != 0   ? row->failure
            : qcGpuRow_Agrees(row) ? "equal"
                                   : "DIFFERENT");
}

/// Times by one clock: a line for each stage, a column for each row of the table.
static void WriteStages(FILE* stream, const qcGpuRow* rows, uint32_t rowCount, bool byDevice)
{
    for (uint32_t stage = 0; stage < rows[0].stageCount; ++stage)
    {
        bool any = false;
        for (uint32_t i = 0; i < rowCount; ++i)
            any = any || (byDevice ? rows[i].stages[stage].deviceMs : rows[i].stages[stage].threadMs) >= 0.0;
        if (!any)
            continue;
        fprintf(stream, "  %-15s", rows[0].stages[stage].name);
        for (uint32_t i = 0; i < rowCount; ++i)
        {
            double ms = byDevice ? rows[i].stages[stage].deviceMs : rows[i].stages[stage].threadMs;
            if (ms >= 0.0)
                fprintf(stream, " %9.4f", ms);
            else
                fprintf(stream, " %9s", "n/a");
        }
        fputc('\n', stream);
    }
}

static bool HasDeviceTimes(const qcGpuRow* rows, uint32_t rowCount)
{
    for (uint32_t i = 0; i < rowCount; ++i)
        for (uint32_t stage = 0; stage < rows[i].stageCount; ++stage)
            if (rows[i].stages[stage].deviceMs >= 0.0)
                return true;
    return false;
}

static void WriteSizes(FILE* stream, const char* title, const qcGpuRow* rows, uint32_t rowCount)
{
    fprintf(stream, "\n  %-15s", title);
    for (uint32_t i = 0; i < rowCount; ++i)
        fprintf(stream, " %9" PRIu32, rows[i].triangles);
    fputc('\n', stream);
}

/// What a steady step of layers costs the processor.
static void WriteCounts(FILE* stream, const qcGpuRow* rows, uint32_t rowCount)
{
    WriteSizes(stream, "a steady step", rows, rowCount);
    fprintf(stream, "  %-15s", "GL calls");
    for (uint32_t i = 0; i < rowCount; ++i)
        fprintf(stream, " %9" PRIu32, rows[i].deviceCalls);
    fprintf(stream, "\n  %-15s", "waits");
    for (uint32_t i = 0; i < rowCount; ++i)
        fprintf(stream, " %9" PRIu32, rows[i].deviceWaits);
    fprintf(stream, "\n  %-15s", "bytes written");
    for (uint32_t i = 0; i < rowCount; ++i)
        fprintf(stream, " %9" PRIu64, rows[i].uploadedBytes);
    fprintf(stream, "\n  %-15s", "allocations");
    for (uint32_t i = 0; i < rowCount; ++i)
        fprintf(stream, " %9" PRIu64, rows[i].runs[0].allocations);
    fprintf(stream, "\n  %-15s", "processor, ms");
    for (uint32_t i = 0; i < rowCount; ++i)
        fprintf(stream, " %9.4f", rows[i].processorMs);
    fputc('\n', stream);
}

void qcGpu_WriteScene(FILE* stream, const qcGpuTable* table, int scene)
{
    const qcGpuRow* rows = table->rows;
    uint32_t rowCount = 0, left = table->rowCount;
    for (; left != 0 && rows->scene != scene; --left)
        ++rows;
    while (rowCount < left && rows[rowCount].scene == scene)
        ++rowCount;
    if (rowCount == 0)
        return;
    fprintf(stream, "\n%s: %s, ms a step; speed-up of layers over sweep on %" PRIu32 "\n%9s", qcGpuScene_Name(scene),
            qcGpuScene_Title(scene), rows[0].runs[rows[0].runCount - 1].threads, "triangles");
    for (uint32_t i = 0; i < rows[0].runCount; ++i)
        fprintf(stream, " %6s %4" PRIu32, qcMethod_Name(rows[0].runs[i].method), rows[0].runs[i].threads);
    fprintf(stream, " %9s %13s %9s  %-16s  %s\n", "speed-up", "auto / better", "pairs", "hash", "lists");
    for (uint32_t i = 0; i < rowCount; ++i)
        WriteRuns(stream, &rows[i]);
    WriteSizes(stream, "device, ms", rows, rowCount);
    if (HasDeviceTimes(rows, rowCount))
        WriteStages(stream, rows, rowCount, true);
    else
        fputs("  n/a: the device has no timestamps\n", stream);
    WriteSizes(stream, "threads, ms", rows, rowCount);
    WriteStages(stream, rows, rowCount, false);
    WriteCounts(stream, rows, rowCount);
}

static bool WriteText(const qcGpuOptions* options, const qcGpuDevice* device, const qcGpuTable* table,
                      qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(options->out, "gpu.txt", &output, message))
        return false;
    qcGpu_WriteDevice(output.stream, options, device);
    for (int scene = 0; scene < qc_gpuSceneCount; ++scene)
        qcGpu_WriteScene(output.stream, table, scene);
    return qcOutput_Commit(&output, message);
}

//  ---- CSV -----------------------------------------------------------------------------------------

static void WriteRow(FILE* stream, const qcGpuDevice* device, const qcGpuRow* row)
{
    for (uint32_t i = 0; i < row->runCount; ++i)
    {
        const qcGpuRun* run = &row->runs[i];
        bool isLayers = run->method == qc_methodLayers;
        fprintf(stream,
                "%s,%" PRIu32 ",%" PRIu32 ",%s,%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%.4f,%.4f,%.4f,%" PRIu64 ",%" PRIu64,
                qcGpuScene_Name(row->scene), row->bodies, row->triangles, qcMethod_Name(run->method), run->threads,
                run->steps, run->deviceSteps, run->ms, run->minMs, run->firstMs, run->candidates, run->pairs);
        for (int frame = 0; frame < qc_gpuFrames; ++frame)
            fprintf(stream, "%s%016" PRIx64, frame == 0 ? "," : "-", run->hashes[frame]);
        fprintf(stream, ",%d,%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu32 ",%" PRIu32 ",%" PRIu64 ",%.4f,",
                qcGpuRow_Agrees(row), isLayers ? row->entries : 0, isLayers ? row->uploadedBytes : 0,
                isLayers ? row->deviceBytes : 0, isLayers ? row->deviceCalls : 0, isLayers ? row->deviceWaits : 0,
                run->allocations, isLayers ? row->processorMs : 0.0);
        qcFiles_WriteQuoted(stream, isLayers ? row->failure : "");
        fputc(',', stream);
        qcFiles_WriteQuoted(stream, isLayers ? device->info.renderer : "");
        fputc('\n', stream);
    }
}

static void WriteTime(FILE* stream, double ms)
{
    if (ms >= 0.0)
        fprintf(stream, ",%.5f", ms);
    else
        fputs(",n/a", stream);
}

static void WriteRowStages(FILE* stream, const qcGpuRow* row)
{
    for (uint32_t i = 0; i < row->stageCount; ++i)
    {
        fprintf(stream, "%s,%" PRIu32 ",%s", qcGpuScene_Name(row->scene), row->triangles, row->stages[i].name);
        WriteTime(stream, row->stages[i].threadMs);
        WriteTime(stream, row->stages[i].deviceMs);
        fputc('\n', stream);
    }
}

bool qcGpu_WriteFiles(const qcGpuOptions* options, const qcGpuDevice* device, const qcGpuTable* table,
                      qcMessage* message)
{
    qcOutput rows, stages;
    if (!qcFiles_Open(options->out, "gpu.csv", &rows, message))
        return false;
    fputs("scene,bodies,triangles,method,threads,steps,device_steps,ms,ms_least,first_ms,candidates,pairs,hash,agrees,"
          "entries,uploaded_bytes,device_bytes,gl_calls,waits,allocations,processor_ms,failure,renderer\n",
          rows.stream);
    for (uint32_t i = 0; i < table->rowCount; ++i)
        WriteRow(rows.stream, device, &table->rows[i]);
    if (!qcOutput_Commit(&rows, message) || !qcFiles_Open(options->out, "gpu_stages.csv", &stages, message))
        return false;
    fputs("scene,triangles,stage,thread_ms,device_ms\n", stages.stream);
    for (uint32_t i = 0; i < table->rowCount; ++i)
        WriteRowStages(stages.stream, &table->rows[i]);
    return qcOutput_Commit(&stages, message) && WriteText(options, device, table, message);
}
