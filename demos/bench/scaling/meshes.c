// Time and memory of the sweep over a folded cloth, against its number of triangles.
#include "bench/scaling/scaling.h"

#include "bench/scenes/motion.h"
#include "bench/scenes/shapes.h"
#include "common/stopwatch.h"
#include "common/progress.h"

#include <quickcullide/quickcullide.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum
{
    qc_frameCount = 4,
    qc_minSteps = 8,
    qc_maxSteps = 64
};

// The time limit of one size.
static const double s_enoughMs = 600.0;

static const uint32_t s_sizes[qc_scalingMeshSizes] = {1000,   2000,   4000,   8000,    20000,   40000,  80000,
                                                      160000, 250000, 500000, 1000000, 2000000, 4000000};

uint32_t qcScaling_CountMeshSizes(const qcScalingOptions* options)
{
    uint32_t count = 0;
    while (count < qc_scalingMeshSizes && s_sizes[count] <= options->maxTriangles)
        ++count;
    return count;
}

/// A cloth in motion.
typedef struct Cloth
{
    qcMesh mesh;
    float* frames[qc_frameCount];
} Cloth;

static void FreeCloth(Cloth* cloth)
{
    qcMesh_Free(&cloth->mesh);
    for (int i = 0; i < qc_frameCount; ++i)
        free(cloth->frames[i]);
}

static bool MakeCloth(uint32_t triangles, Cloth* cloth)
{
    *cloth = (Cloth){.frames = {NULL}};
    if (!qcBenchShapes_MakeCloth((uint32_t)lround(sqrt(0.5 * triangles)), 1.0, &cloth->mesh))
        return false;
    qcBenchMotion motion = qcBenchMotion_Make(&cloth->mesh, 1, qc_frameCount);
    for (uint32_t i = 0; i < qc_frameCount; ++i)
    {
        cloth->frames[i] = malloc((size_t)cloth->mesh.vertexCount * 3 * sizeof(float));
        if (cloth->frames[i] == NULL)
        {
            FreeCloth(cloth);
            return false;
        }
        qcBenchMotion_Deform(&motion, &cloth->mesh, i, cloth->frames[i]);
    }
    return true;
}

typedef struct Times
{
    double total[qc_maxSteps], stages[qc_scalingStageCount][qc_maxSteps];
} Times;

typedef struct Bench
{
    const Cloth* cloth;
    qcScene* scene;
    qcBodyId body;
    uint32_t frame;
    const qcResult* result;
} Bench;

static qcStatus Open(const Cloth* cloth, Bench* bench)
{
    *bench = (Bench){.cloth = cloth};
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcStatus status = qcScene_Create(&sceneDef, &bench->scene);
    if (status != qc_statusOk)
        return status;
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = cloth->frames[qc_frameCount - 1];
    def.vertexCount = cloth->mesh.vertexCount;
    def.indices = cloth->mesh.indices;
    def.triangleCount = cloth->mesh.triangleCount;
    def.deforming = true;
    return qcScene_AddBody(bench->scene, &def, &bench->body);
}

/// Sets new vertices and detects; `verticesMs`: the time of the former alone.
static qcStatus Step(Bench* bench, uint32_t threads, double* ms, double* verticesMs)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.threads = threads;
    const float* positions = bench->cloth->frames[bench->frame++ % qc_frameCount];
    double start = qcStopwatch_NowMs();
    qcStatus status = qcScene_SetVertices(bench->scene, bench->body, positions, qc_positionF32, 0);
    *verticesMs = qcStopwatch_NowMs() - start;
    if (status == qc_statusOk)
        status = qcScene_Detect(bench->scene, &def, &bench->result);
    *ms = qcStopwatch_NowMs() - start;
    return status;
}

static void Keep(const qcProfile* profile, double ms, double verticesMs, uint32_t step, Times* times)
{
    double stages[qc_scalingStageCount] = {[qc_stageVertices] = verticesMs,
                                           [qc_stageObjects] =
                                               profile->planMs + profile->cullObjectsMs + profile->sweepObjectsMs,
                                           [qc_stageTriangles] = profile->cullTrianglesMs + profile->sweepTrianglesMs,
                                           [qc_stageExact] = profile->exactMs};
    double named = 0.0;
    for (int i = 0; i < qc_stageOther; ++i)
        named += stages[i];
    stages[qc_stageOther] = ms > named ? ms - named : 0.0;
    times->total[step] = ms;
    for (int i = 0; i < qc_scalingStageCount; ++i)
        times->stages[i][step] = stages[i];
}

static qcStatus Time(Bench* bench, Times* times, qcScalingMeshRow* row)
{
    double ms, verticesMs, spent = 0.0;
    // The BVH is built in the second step; buffers may grow a last time in the third.
    qcStatus status = Step(bench, row->threads, &row->firstMs, &verticesMs);
    if (status == qc_statusOk)
        status = Step(bench, row->threads, &row->secondMs, &verticesMs);
    if (status == qc_statusOk)
        status = Step(bench, row->threads, &ms, &verticesMs);
    while (status == qc_statusOk && (row->steps < qc_minSteps || (row->steps < qc_maxSteps && spent < s_enoughMs)))
    {
        status = Step(bench, row->threads, &ms, &verticesMs);
        if (status != qc_statusOk)
            break;
        spent += ms;
        Keep(&bench->result->profile, ms, verticesMs, row->steps++, times);
    }
    return status;
}

static bool MeasureRow(const Cloth* cloth, Times* times, qcScalingMeshRow* row, qcMessage* message)
{
    Bench bench;
    size_t before = qcGetByteCount();
    qcStopwatch_Rest();
    qcStatus status = Open(cloth, &bench);
    if (status == qc_statusOk)
        status = Time(&bench, times, row);
    if (status == qc_statusOk)
    {
        row->ms = qcStopwatch_Median(times->total, row->steps);
        row->minMs = times->total[0];
        for (int i = 0; i < qc_scalingStageCount; ++i)
            row->stages[i] = qcStopwatch_Median(times->stages[i], row->steps);
        row->bytes = (double)(qcGetByteCount() - before) / row->triangles;
        row->candidates = bench.result->profile.candidates;
        row->pairs = bench.result->pairCount;
    }
    else
        qcMessage_Fail(message, "%u triangles: %s", row->triangles, qcLastMessage());
    qcScene_Destroy(bench.scene);
    return status == qc_statusOk;
}

bool qcScaling_MeasureMesh(const qcScalingOptions* options, uint32_t size, qcScalingMeshRow* rows, qcMessage* message)
{
    Cloth cloth;
    char label[64];
    snprintf(label, sizeof label, "%u triangles", s_sizes[size]);
    Times* times = malloc(sizeof *times);
    if (times == NULL || !MakeCloth(s_sizes[size], &cloth))
    {
        free(times);
        return qcMessage_Fail(message, "out of memory");
    }
    qcProgress_Begin(options->threadsCount, label);
    bool measured = true;
    for (uint32_t i = 0; measured && i < options->threadsCount; ++i)
    {
        rows[i] = (qcScalingMeshRow){.triangles = cloth.mesh.triangleCount, .threads = options->threads[i]};
        measured = MeasureRow(&cloth, times, &rows[i], message);
        qcProgress_Update(i + 1);
    }
    qcProgress_End();
    FreeCloth(&cloth);
    free(times);
    return measured;
}
