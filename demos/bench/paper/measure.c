// Each method goes through a recording on its own, in a scene of its own: the sampled ones once, in the chosen frames,
// the others in all frames and in several rounds, in turns, so that a disturbance of the machine slows all of them.
#include "bench/paper/paper.h"

#include "common/progress.h"
#include "common/stopwatch.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

const qcPaperMethodInfo qcPaperMethods[qc_paperMethodCount] = {
    {"cullide", "cullide", qc_methodCullide, false, false, true},
    {"quick", "quick", qc_methodQuick, false, false, true},
    {"quick, back to front", "quick_sorted", qc_methodQuick, true, false, true},
    {"  and second pass from the back", "quick_sorted_back", qc_methodQuick, true, true, true},
    {"sweep", "sweep", qc_methodSweep, false, false, false},
    {"layers", "layers", qc_methodLayers, false, false, false},
    {"auto", "auto", qc_methodAuto, false, false, false},
    {"Embree", "embree", qc_methodAuto, false, false, false},
};

typedef struct Run
{
    const qcPaperOptions* options;
    const char* path;
    qcDevice* device;
    qcPaperTable* table;
} Run;

//  ---- preparation ---------------------------------------------------------------------------------

static bool Allocate(qcPaperTable* table, qcMessage* message)
{
    size_t frames = table->info.frameCount;
    table->isChosen = calloc(frames, sizeof *table->isChosen);
    table->exact = calloc(frames, sizeof *table->exact);
    table->hashes = calloc(frames, sizeof *table->hashes);
    bool made = table->isChosen != NULL && table->exact != NULL && table->hashes != NULL;
    for (int method = 0; method < qc_paperMethodCount; ++method)
    {
        table->cells[method] = calloc(frames, sizeof *table->cells[method]);
        made = made && table->cells[method] != NULL;
    }
    return made || qcMessage_Fail(message, "out of memory");
}

/// Chooses frames at equal distances.
static void ChooseFrames(const qcPaperOptions* options, qcPaperTable* table)
{
    uint32_t frames = table->info.frameCount, count = options->frames != 0 ? options->frames : table->scene->frames;
    count = options->allFrames || count > frames ? frames : count;
    for (uint32_t i = 0; i < count; ++i)
        table->isChosen[(uint32_t)((2 * (uint64_t)i + 1) * frames / (2 * count))] = true;
    table->chosenCount = count;
}

void qcPaperTable_Free(qcPaperTable* table)
{
    free(table->isChosen);
    free(table->exact);
    free(table->hashes);
    for (int method = 0; method < qc_paperMethodCount; ++method)
        free(table->cells[method]);
}

//  ---- a pass --------------------------------------------------------------------------------------

/// Compares the pairs with those of `sweep`, and these with the recorded ones.
static bool Judge(const Run* run, const qcPaperReplay* replay, qcPaperMethod method, const qcResult* result,
                  qcMessage* message)
{
    qcPaperTable* table = run->table;
    uint32_t frame = replay->frame;
    uint64_t hash = qcResult_Hash(result).pairs;
    const qcOperation* recorded = replay->detection;
    if (method == qc_paperSweep)
    {
        table->exact[frame] = result->pairCount;
        table->hashes[frame] = hash;
        const qcDetectDef* def = &recorded->detect;
        bool isPlain = def->margin == 0.0 && !def->touching && !def->neighbours && !def->motion &&
                       (def->method == qc_methodSweep || def->method == qc_methodAuto);
        if (isPlain && recorded->hasResult && recorded->resultStatus == qc_statusOk &&
            recorded->resultHash.pairs != hash)
            return qcMessage_Fail(message, "%s, frame %u: other pairs than those recorded", run->path, frame);
    }
    qcPaperCell* cell = &table->cells[method][frame];
    cell->missed = table->exact[frame] > result->pairCount ? table->exact[frame] - result->pairCount : 0;
    if (qcPaperMethods[method].isSampled || hash == table->hashes[frame])
        return true;
    return qcMessage_Fail(message, "%s, frame %u: %s finds other pairs than sweep", run->path, frame,
                          qcPaperMethods[method].label);
}

static bool RunFrame(const Run* run, qcPaperReplay* replay, qcPaperMethod method, uint32_t resolution,
                     qcMessage* message)
{
    const qcPaperMethodInfo* info = &qcPaperMethods[method];
    qcDetectDef def = qcPaperReplay_PlainDef(replay);
    def.method = info->method;
    def.backToFront = info->backToFront;
    def.secondPassFromBack = info->secondPassFromBack;
    def.resolution = resolution;
    def.iterations = run->options->iterations;
    def.threads = run->options->threads;
    const qcResult* result;
    double ms;
    if (!qcPaperReplay_Detect(replay, &def, &result, &ms, message))
        return false;
    qcPaperCell* cell = &run->table->cells[method][replay->frame];
    cell->ran = true;
    cell->pcs = (uint32_t)result->pcsCount;
    cell->found = result->pairCount;
    if (cell->timeCount < qc_maxPaperRounds)
        cell->times[cell->timeCount++] = ms;
    return Judge(run, replay, method, result, message);
}

/// One method through the recording.
static bool RunPass(const Run* run, qcPaperMethod method, qcMessage* message)
{
    char label[128];
    bool isSampled = qcPaperMethods[method].isSampled;
    snprintf(label, sizeof label, "%s: %s", run->table->scene->name, qcPaperMethods[method].column);
    qcPaperReplay replay;
    bool more = true, done = qcPaperReplay_Open(run->path, run->device, &replay, message);
    replay.frameLimit = run->table->info.frameCount;
    qcProgress_Begin(run->table->info.frameCount, label);
    while (done && more)
    {
        done = qcPaperReplay_Next(&replay, &more, message);
        if (done && more && (!isSampled || run->table->isChosen[replay.frame]))
            done = RunFrame(run, &replay, method, run->table->resolution, message);
        qcProgress_Update(replay.nextFrame);
    }
    qcProgress_End();
    qcPaperReplay_Close(&replay);
    return done;
}

/// Runs each method that needs GL once on the first frame, so that no measurement includes kernels being compiled and
/// the planner being calibrated.
static bool WarmUp(const Run* run, qcMessage* message)
{
    qcPaperReplay replay;
    bool more, done = qcPaperReplay_Open(run->path, run->device, &replay, message) &&
                      qcPaperReplay_Next(&replay, &more, message);
    const qcMethod methods[] = {qc_methodSweep, qc_methodAuto, qc_methodLayers, qc_methodQuick, qc_methodCullide};
    for (int i = 0; done && i < 5; ++i)
    {
        qcDetectDef def = qcPaperReplay_PlainDef(&replay);
        const qcResult* result;
        double ms;
        def.method = methods[i];
        def.resolution = 64;
        def.iterations = 1;
        done = qcPaperReplay_Detect(&replay, &def, &result, &ms, message);
    }
    qcPaperReplay_Close(&replay);
    return done;
}

static void FinishTimes(qcPaperTable* table)
{
    for (int method = 0; method < qc_paperMethodCount; ++method)
        for (uint32_t frame = 0; frame < table->info.frameCount; ++frame)
        {
            qcPaperCell* cell = &table->cells[method][frame];
            cell->ms = qcStopwatch_Median(cell->times, cell->timeCount);
        }
}

static bool RunAll(const Run* run, bool hasGl, bool hasCompute, qcMessage* message)
{
    static const qcPaperMethod exact[] = {qc_paperSweep, qc_paperLayers, qc_paperAuto};
    for (uint32_t round = 0; round < run->options->rounds; ++round)
    {
        for (uint32_t i = 0; i < 3; ++i)
        {
            // The reference comes first in the first round; then the order changes.
            qcPaperMethod method = exact[(i + round) % 3];
            if (!hasCompute && method == qc_paperLayers)
                continue;
            if (!RunPass(run, method, message))
                return false;
        }
        if (round % 2 == 0 && !qcPaper_MeasureEmbree(run->options, run->path, round, run->table, message))
            return false;
    }
    for (int method = 0; hasGl && method < qc_paperMethodCount; ++method)
        if (qcPaperMethods[method].isSampled && !RunPass(run, (qcPaperMethod)method, message))
            return false;
    return true;
}

bool qcPaper_Measure(const qcPaperOptions* options, const qcPaperScene* scene, const char* path,
                     const qcPaperRecordingInfo* info, qcDevice* device, qcPaperTable* table, qcMessage* message)
{
    *table = (qcPaperTable){.scene = scene, .info = *info, .iterations = options->iterations};
    const Run run = {options, path, device, table};
    qcDeviceInfo gl;
    if (!Allocate(table, message))
        return false;
    if (qcDevice_GetInfo(device, &gl) != qc_statusOk)
        return qcMessage_Fail(message, "%s", qcLastMessage());
    table->resolution = options->resolution < gl.maxResolution ? options->resolution : gl.maxResolution;
    ChooseFrames(options, table);
    if (!WarmUp(&run, message) || !RunAll(&run, gl.kind != qc_deviceNone, gl.compute, message))
        return false;
    FinishTimes(table);
    return true;
}

qcPaperSummary qcPaperTable_Summarize(const qcPaperTable* table, qcPaperMethod method, bool chosenOnly)
{
    qcPaperSummary sum = {0};
    for (uint32_t frame = 0; frame < table->info.frameCount; ++frame)
    {
        const qcPaperCell* cell = &table->cells[method][frame];
        bool isBuilding = frame < qc_paperBuildingFrames && !table->isChosen[frame];
        if (!cell->ran || (chosenOnly ? !table->isChosen[frame] : isBuilding))
            continue;
        ++sum.frames;
        sum.pcs += cell->pcs;
        sum.ms += cell->ms;
        sum.exact += table->exact[frame];
        sum.missed += cell->missed;
    }
    if (sum.frames != 0)
    {
        sum.pcs /= sum.frames;
        sum.ms /= sum.frames;
    }
    return sum;
}
