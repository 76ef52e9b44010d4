// One scene with every setting: time, number of pairs, and those that the reference lacks or has in addition.
//
// A timed run is a step of a deforming scene: new vertices for each body, then the detection. The scene was in another
// pose before it, so that no earlier result can be reused.
#include "bench/accuracy/accuracy.h"

#include "bench/scenes/shapes.h"
#include "common/stopwatch.h"
#include "common/progress.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum
{
    qc_minRuns = 3
};

// The time limit of one setting.
static const double s_enoughMs = 500.0;

typedef struct Bench
{
    const qcAccuracyOptions* options;
    const qcBenchScene* bodies;
    void** poses; ///< of each body: its positions, each vertex moved a little
    qcBodyId* ids;
    qcScene* scene;
    const qcResult* result; ///< of the last detection
    qcPair* exact;
    qcAccuracyTable* table;
} Bench;

//  ---- the scene -----------------------------------------------------------------------------------

static size_t PositionSize(const qcMesh* mesh)
{
    return 3 * (size_t)mesh->vertexCount * (mesh->isDouble ? sizeof(double) : sizeof(float));
}

/// Moves each vertex by up to `distance` along each axis: about its motion in a step of a simulation.
static void MakePose(const qcMesh* mesh, double distance, void* pose)
{
    uint64_t seed = 1;
    for (size_t i = 0; i < 3 * (size_t)mesh->vertexCount; ++i)
    {
        double step = qcBenchShapes_Random(&seed, -distance, distance);
        if (mesh->isDouble)
            ((double*)pose)[i] = ((const double*)mesh->positions)[i] + step;
        else
            ((float*)pose)[i] = (float)(((const float*)mesh->positions)[i] + step);
    }
}

static qcStatus AddBody(Bench* bench, uint32_t index)
{
    const qcMesh* mesh = &bench->bodies->bodies[index];
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = mesh->positions;
    def.positionType = mesh->isDouble ? qc_positionF64 : qc_positionF32;
    def.vertexCount = mesh->vertexCount;
    def.indices = mesh->indices;
    def.triangleCount = mesh->triangleCount;
    def.deforming = true;
    return qcScene_AddBody(bench->scene, &def, &bench->ids[index]);
}

static bool Fail(qcMessage* message, const char* what)
{
    return qcMessage_Fail(message, "%s: %s", what, qcLastMessage());
}

static bool Open(Bench* bench, qcDevice* device, qcMessage* message)
{
    const qcBenchScene* bodies = bench->bodies;
    bench->poses = calloc(bodies->bodyCount, sizeof *bench->poses);
    bench->ids = calloc(bodies->bodyCount, sizeof *bench->ids);
    if (bench->poses == NULL || bench->ids == NULL)
        return qcMessage_Fail(message, "out of memory");
    qcSceneDef def = qcDefaultSceneDef();
    def.device = device;
    if (qcScene_Create(&def, &bench->scene) != qc_statusOk)
        return Fail(message, "making the scene");
    for (uint32_t i = 0; i < bodies->bodyCount; ++i)
    {
        bench->poses[i] = malloc(PositionSize(&bodies->bodies[i]));
        if (bench->poses[i] == NULL)
            return qcMessage_Fail(message, "out of memory");
        MakePose(&bodies->bodies[i], 1e-4 * bodies->extent, bench->poses[i]);
        if (AddBody(bench, i) != qc_statusOk)
            return Fail(message, "making the scene");
    }
    return true;
}

static void Close(Bench* bench)
{
    qcScene_Destroy(bench->scene);
    for (uint32_t i = 0; bench->poses != NULL && i < bench->bodies->bodyCount; ++i)
        free(bench->poses[i]);
    free(bench->poses);
    free(bench->ids);
    free(bench->exact);
}

static qcStatus SetVertices(Bench* bench, bool pose)
{
    qcStatus status = qc_statusOk;
    for (uint32_t i = 0; status == qc_statusOk && i < bench->bodies->bodyCount; ++i)
    {
        const qcMesh* mesh = &bench->bodies->bodies[i];
        status = qcScene_SetVertices(bench->scene, bench->ids[i], pose ? bench->poses[i] : mesh->positions,
                                     mesh->isDouble ? qc_positionF64 : qc_positionF32, 0);
    }
    return status;
}

//  ---- a run ---------------------------------------------------------------------------------------

static qcDetectDef MakeDef(const Bench* bench, const qcAccuracySetting* setting)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = setting->method;
    def.margin = bench->table->margin;
    def.touching = bench->options->touching;
    def.threads = bench->options->threads;
    def.iterations = bench->options->rounds;
    if (setting->method == qc_methodLayers)
    {
        def.layerColumns = setting->resolution;
        def.layerDepthAxis = setting->views[0];
    }
    else if (qcAccuracy_IsSampled(setting->method))
    {
        def.resolution = setting->resolution;
        memcpy(def.views, setting->views, sizeof def.views);
    }
    def.backToFront = setting->backToFront;
    def.secondPassFromBack = setting->secondPassFromBack;
    def.reliable = setting->reliable;
    return def;
}

/// Sets new vertices and detects.
static qcStatus Step(Bench* bench, const qcDetectDef* def, bool pose, double* ms)
{
    double start = qcStopwatch_NowMs();
    qcStatus status = SetVertices(bench, pose);
    if (status == qc_statusOk)
        status = qcScene_Detect(bench->scene, def, &bench->result);
    *ms = qcStopwatch_NowMs() - start;
    return status;
}

static int ComparePairs(const qcPair* a, const qcPair* b)
{
    const uint32_t p[4] = {a->bodyA, a->triangleA, a->bodyB, a->triangleB};
    const uint32_t q[4] = {b->bodyA, b->triangleA, b->bodyB, b->triangleB};
    for (int i = 0; i < 4; ++i)
    {
        if (p[i] != q[i])
            return p[i] < q[i] ? -1 : 1;
    }
    return 0;
}

/// Both lists are sorted. A pair reported with another relation is counted as missed and as additional.
static void CountPairs(const Bench* bench, qcAccuracyRow* row)
{
    const qcPair* found = bench->result->pairs;
    size_t e = 0, f = 0, exactCount = (size_t)bench->table->exact, foundCount = bench->result->pairCount;
    while (e < exactCount && f < foundCount)
    {
        int order = ComparePairs(&bench->exact[e], &found[f]);
        if (order == 0)
            row->found += bench->exact[e].relation == found[f].relation;
        e += order <= 0;
        f += order >= 0;
    }
    row->missed = exactCount - row->found;
    row->extra = foundCount - row->found;
}

static void TakeAnswer(const Bench* bench, qcAccuracyRow* row)
{
    const qcProfile* profile = &bench->result->profile;
    row->ran = profile->method;
    row->image = profile->method == qc_methodLayers ? profile->columns : profile->resolution;
    row->queries = profile->queries;
    row->pcs = bench->result->pcsCount;
    row->candidates = profile->candidates;
    CountPairs(bench, row);
    if (profile->fallback == NULL)
        return;
    if (row->setting.method == qc_methodAuto)
        snprintf(row->note, sizeof row->note, "%s", profile->fallback);
    else
        snprintf(row->skipped, sizeof row->skipped, "%s would answer: %s", qcMethod_Name(profile->method),
                 profile->fallback);
}

/// A first run slower than this is not repeated: noise is small relative to it.
static double SlowMs(const qcAccuracySetting* setting)
{
    if (qcAccuracy_IsSampled(setting->method) || setting->method == qc_methodBrute)
        return 100.0;
    // The first run may have grown buffers. Settings without an image, the defaults of a user, are always measured
    // again.
    return setting->resolution != 0 ? 1000.0 : HUGE_VAL;
}

/// A slow first run is the only one. A fast one is discarded, since it may include allocation.
static qcStatus Time(Bench* bench, const qcDetectDef* def, double firstMs, qcAccuracyRow* row)
{
    double times[qc_maxRuns] = {firstMs}, spent = 0.0, other;
    row->runs = 1;
    if (bench->options->runs > 1 && firstMs < SlowMs(&row->setting))
    {
        uint32_t most = bench->options->runs, least = most < qc_minRuns ? most : qc_minRuns;
        for (row->runs = 0; row->runs < least || (row->runs < most && spent < s_enoughMs); ++row->runs)
        {
            qcStatus status = Step(bench, def, true, &other);
            if (status == qc_statusOk)
                status = Step(bench, def, false, &times[row->runs]);
            if (status != qc_statusOk)
                return status;
            spent += times[row->runs] + other;
        }
    }
    row->ms = qcStopwatch_Median(times, row->runs);
    row->minMs = times[0];
    return qc_statusOk;
}

static qcStatus MeasureSetting(Bench* bench, qcAccuracyRow* row)
{
    qcDetectDef def = MakeDef(bench, &row->setting);
    double ms;
    // Begins from the other pose, whatever the last setting left.
    qcStatus status = SetVertices(bench, true);
    if (status == qc_statusOk)
        status = Step(bench, &def, false, &ms);
    if (status != qc_statusOk)
        return status;
    TakeAnswer(bench, row);
    return row->skipped[0] != 0 ? qc_statusOk : Time(bench, &def, ms, row);
}

//  ---- all settings --------------------------------------------------------------------------------

static bool FindExact(Bench* bench, qcMessage* message)
{
    qcAccuracySetting setting = {.method = bench->table->reference};
    qcDetectDef def = MakeDef(bench, &setting);
    char label[64];
    snprintf(label, sizeof label, "%s: the exact pairs", qcBenchScene_Name(bench->table->scene));
    qcProgress_Begin(0, label);
    qcStatus status = qcScene_Detect(bench->scene, &def, &bench->result);
    qcProgress_End();
    if (status != qc_statusOk)
        return Fail(message, label);
    size_t size = bench->result->pairCount * sizeof(qcPair);
    bench->exact = malloc(size + 1);
    if (bench->exact == NULL)
        return qcMessage_Fail(message, "out of memory");
    if (size != 0)
        memcpy(bench->exact, bench->result->pairs, size);
    bench->table->exact = bench->result->pairCount;
    return true;
}

static bool MakeRows(const Bench* bench, qcAccuracyTable* table)
{
    qcAccuracySetting* settings = malloc(qc_maxSettings * sizeof *settings);
    uint32_t count = 0;
    if (settings != NULL)
    {
        count = qcAccuracy_ListSettings(bench->options, table->scene, table->triangleCount, settings);
        table->rows = calloc(count + 1, sizeof *table->rows);
    }
    for (uint32_t i = 0; table->rows != NULL && i < count; ++i)
        table->rows[i].setting = settings[i];
    free(settings);
    table->rowCount = table->rows != NULL ? count : 0;
    return table->rows != NULL;
}

static bool MeasureAll(Bench* bench, qcMessage* message)
{
    qcAccuracyTable* table = bench->table;
    if (!FindExact(bench, message))
        return false;
    if (!MakeRows(bench, table))
        return qcMessage_Fail(message, "out of memory");
    qcProgress_Begin(table->rowCount, qcBenchScene_Name(table->scene));
    bool measured = true;
    for (uint32_t i = 0; measured && i < table->rowCount; ++i)
    {
        qcAccuracyRow* row = &table->rows[i];
        qcMethod method = row->setting.method;
        if (MeasureSetting(bench, row) != qc_statusOk)
        {
            // These methods must run: there is no reason to skip them.
            if (method == qc_methodAuto || method == qc_methodSweep || method == qc_methodBrute)
                measured = Fail(message, qcMethod_Name(method));
            snprintf(row->skipped, sizeof row->skipped, "%s", qcLastMessage());
        }
        qcProgress_Update(i + 1);
    }
    qcProgress_End();
    return measured;
}

bool qcAccuracy_Measure(const qcAccuracyOptions* options, const qcBenchScene* scene, qcDevice* device,
                        qcAccuracyTable* table, qcMessage* message)
{
    table->bodyCount = scene->bodyCount;
    table->triangleCount = scene->triangleCount;
    table->margin = options->margin * scene->extent;
    table->reference = qcAccuracy_ChooseReference(options, scene->triangleCount);
    Bench bench = {.options = options, .bodies = scene, .table = table};
    bool measured = Open(&bench, device, message) && MeasureAll(&bench, message);
    Close(&bench);
    return measured;
}

void qcAccuracy_WarmUp(const qcAccuracyOptions* options, qcDevice* device)
{
    float positions[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1};
    uint32_t indices[6] = {0, 1, 2, 3, 4, 5};
    qcMesh mesh = {.positions = positions, .vertexCount = 6, .indices = indices, .triangleCount = 2};
    qcBenchScene scene = {.bodies = &mesh, .bodyCount = 1, .triangleCount = 2, .extent = 1.0};
    qcAccuracyTable table = {0};
    qcMessage message;
    Bench bench = {.options = options, .bodies = &scene, .table = &table};
    // Failures are ignored here: they recur in the measurement, which reports them.
    if (Open(&bench, device, &message))
    {
        for (int i = 0; i < qc_methodCount; ++i)
        {
            qcAccuracySetting setting = {.method = (qcMethod)i};
            if (qcAccuracy_IsSampled(setting.method))
                setting = (qcAccuracySetting){.method = setting.method, .resolution = 256, .views = "z"};
            qcDetectDef def = MakeDef(&bench, &setting);
            double ms;
            if (options->methods[i])
                Step(&bench, &def, false, &ms);
        }
    }
    Close(&bench);
}
