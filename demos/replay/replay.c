// Two scenes where a method samples: the second one, by the sweep, has the pairs that the first one may miss.
#include "replay/replay.h"

#include "common/interrupt.h"
#include "common/progress.h"
#include "common/stopwatch.h"

#include <stdlib.h>
#include <string.h>

typedef struct Run
{
    const qcReplayOptions* options;
    qcRecording* recording;
    qcScene* scene;
    qcScene* exact; ///< the same bodies; null until a method samples
    qcDetectionFunction* function;
    void* context;
    qcReplayTotals* totals;
    qcMessage* message;
} Run;

static bool Samples(qcMethod method)
{
    return method == qc_methodQuick || method == qc_methodCullide;
}

static qcExitStatus Fail(Run* run, qcStatus status, const char* place)
{
    qcMessage_Fail(run->message, "%s%s", place, qcLastMessage());
    return status == qc_statusDevice || status == qc_statusDeviceLost ? qc_exitDevice
           : status == qc_statusOutOfMemory                           ? qc_exitFailed
                                                                      : qc_exitBadInput;
}

//  ---- comparison --------------------------------------------------------------------------------------------------

static void AddReason(qcDetection* detection, const char* text)
{
    size_t length = strlen(detection->reason);
    snprintf(detection->reason + length, sizeof detection->reason - length, "%s%s", length != 0 ? ", " : "", text);
}

/// Names the parts of the results that differ.
static void CompareHashes(const qcResultHash* recorded, const qcResultHash* found, qcDetection* detection)
{
    if (recorded->pairs != found->pairs || recorded->pairCount != found->pairCount)
        AddReason(detection, "pairs");
    if (recorded->segments != found->segments)
        AddReason(detection, "segments");
    if (recorded->proximities != found->proximities)
        AddReason(detection, "proximities");
    if (recorded->contacts != found->contacts || recorded->contactCount != found->contactCount)
        AddReason(detection, "contacts");
    if (recorded->manifolds != found->manifolds || recorded->manifoldCount != found->manifoldCount)
        AddReason(detection, "manifolds");
    if (recorded->manifoldPoints != found->manifoldPoints || recorded->manifoldPointCount != found->manifoldPointCount)
        AddReason(detection, "manifold points");
    detection->verdict = detection->reason[0] != 0 ? qc_verdictDiffers : qc_verdictSame;
}

static void Compare(const qcOperation* operation, const qcDetectDef* def, const qcResult* result,
                    qcDetection* detection)
{
    detection->verdict = qc_verdictNotCompared;
    detection->recordedPairs = operation->resultHash.pairCount;
    if (!operation->hasResult)
        AddReason(detection, "the recording ends in this detection");
    else if (operation->resultStatus != qc_statusOk)
    {
        AddReason(detection, "it failed when it was recorded: ");
        AddReason(detection, qcStatus_Name(operation->resultStatus));
    }
    else if (Samples(operation->detect.method))
        AddReason(detection, "recorded by a method that samples");
    else if (def->motion && (def->method == qc_methodBrute) != (operation->detect.method == qc_methodBrute))
        AddReason(detection, "brute proves fewer pairs of a motion apart than sweep");
    else
    {
        qcResultHash hash = qcResult_Hash(result);
        CompareHashes(&operation->resultHash, &hash, detection);
    }
}

static int ComparePairs(const qcPair* a, const qcPair* b)
{
    const uint32_t x[4] = {a->bodyA, a->triangleA, a->bodyB, a->triangleB};
    const uint32_t y[4] = {b->bodyA, b->triangleA, b->bodyB, b->triangleB};
    for (int i = 0; i < 4; i++)
        if (x[i] != y[i])
            return x[i] < y[i] ? -1 : 1;
    return 0;
}

/// Pairs of `exact` that `found` lacks. Both are sorted.
static uint64_t CountMissed(const qcResult* found, const qcResult* exact)
{
    uint64_t missed = 0;
    for (size_t i = 0, k = 0; i < exact->pairCount; i++)
    {
        while (k < found->pairCount && ComparePairs(&found->pairs[k], &exact->pairs[i]) < 0)
            k++;
        missed += k == found->pairCount || ComparePairs(&found->pairs[k], &exact->pairs[i]) != 0;
    }
    return missed;
}

//  ---- detections --------------------------------------------------------------------------------------------------

static bool AddTime(qcReplayTotals* totals, double ms)
{
    if (totals->timeCount == totals->timeCapacity)
    {
        size_t capacity = totals->timeCapacity != 0 ? 2 * totals->timeCapacity : 256;
        double* times = realloc(totals->times, capacity * sizeof *times);
        if (times == NULL)
            return false;
        totals->times = times;
        totals->timeCapacity = capacity;
    }
    totals->times[totals->timeCount++] = ms;
    return true;
}

bool qcReplay_Count(qcReplayTotals* totals, const qcDetection* detection)
{
    totals->same += detection->verdict == qc_verdictSame;
    totals->differing += detection->verdict == qc_verdictDiffers;
    totals->notCompared += detection->verdict == qc_verdictNotCompared;
    totals->sampled += detection->verdict == qc_verdictMissed || detection->verdict == qc_verdictNoneMissed;
    totals->missedPairs += detection->missed;
    totals->exactPairs += detection->verdict >= qc_verdictMissed && detection->verdict <= qc_verdictNoneMissed
                              ? detection->recordedPairs
                              : 0;
    totals->fallback = detection->fallback != NULL ? detection->fallback : totals->fallback;
    return AddTime(totals, detection->ms);
}

/// A detection that fails in the replay compares by its status. False: the failure is one of the machine, and ends the
/// replay.
static bool CompareFailure(const qcOperation* operation, qcStatus status, qcDetection* detection)
{
    const bool wasRecorded = operation->hasResult && operation->resultStatus == status;
    if (!wasRecorded && status != qc_statusTooManyPairs)
        return false;
    detection->recordedPairs = operation->resultHash.pairCount;
    detection->verdict = wasRecorded ? qc_verdictSame : qc_verdictDiffers;
    if (!wasRecorded)
    {
        AddReason(detection, "status: ");
        AddReason(detection, qcStatus_Name(status));
    }
    return true;
}

/// The definition as options change it. Methods that sample find intersections only, and are compared with all of them.
static qcDetectDef DefOf(const qcReplayOptions* options, const qcDetectDef* recorded)
{
    qcDetectDef def = *recorded;
    if (options->method != qc_recordedMethod)
        def.method = (qcMethod)options->method;
    if (options->threads != qc_recordedThreads)
        def.threads = options->threads;
    if (Samples(def.method))
    {
        def.margin = def.reliable ? def.margin : 0.0;
        def.contactMargin = 0.0;
        def.motion = false;
        def.maxPairs = 0;
    }
    return def;
}

/// Counts the pairs that a method missed.
static qcExitStatus CompareWithSweep(Run* run, const qcDetectDef* given, const qcResult* found, qcDetection* detection)
{
    qcDetectDef def = *given;
    def.method = qc_methodSweep;
    const qcResult* exact;
    qcStatus status = qcScene_Detect(run->exact, &def, &exact);
    if (status != qc_statusOk)
        return Fail(run, status, "the sweep to compare with: ");
    detection->recordedPairs = exact->pairCount;
    detection->missed = CountMissed(found, exact);
    detection->verdict = detection->missed != 0 ? qc_verdictMissed : qc_verdictNoneMissed;
    return qc_exitDone;
}

/// Runs a detection and compares its result.
static qcExitStatus DetectAndCompare(Run* run, const qcOperation* operation, qcDetection* detection)
{
    qcDetectDef def = DefOf(run->options, &operation->detect);
    const qcResult* result;
    double start = qcStopwatch_NowMs();
    qcStatus status = qcScene_Detect(run->scene, &def, &result);
    detection->ms = qcStopwatch_NowMs() - start;
    detection->method = def.method;
    if (status != qc_statusOk)
    {
        if (CompareFailure(operation, status, detection))
            return qc_exitDone;
        char place[96];
        snprintf(place, sizeof place, "detection %llu, operation %llu: ", (unsigned long long)detection->number,
                 (unsigned long long)detection->operation);
        return Fail(run, status, place);
    }
    detection->method = result->profile.method;
    detection->fallback = result->profile.fallback;
    detection->pairs = result->pairCount;
    detection->contacts = result->contactCount;
    detection->points = result->manifoldPointCount;
    if (Samples(def.method))
        return CompareWithSweep(run, &def, result, detection);
    Compare(operation, &def, result, detection);
    return qc_exitDone;
}

static qcExitStatus Detect(Run* run, const qcOperation* operation)
{
    qcReplayTotals* totals = run->totals;
    qcDetection detection = {.number = totals->detections, .operation = operation->number};
    const qcExitStatus ending = DetectAndCompare(run, operation, &detection);
    if (ending != qc_exitDone)
        return ending;
    totals->pairs += detection.pairs;
    run->function(&detection, run->context);
    if (qcReplay_Count(totals, &detection))
        return qc_exitDone;
    qcMessage_Fail(run->message, "out of memory");
    return qc_exitFailed;
}

//  ---- operations --------------------------------------------------------------------------------------------------

static qcExitStatus Apply(Run* run, const qcOperation* operation)
{
    if (operation->kind == qc_operationDetect)
    {
        uint64_t number = ++run->totals->detections;
        qcProgress_Update(number);
        bool runs = number >= run->options->from && number <= run->options->to;
        return runs ? Detect(run, operation) : qc_exitDone;
    }
    qcStatus status = qcOperation_Apply(operation, run->scene, NULL);
    if (status == qc_statusOk && run->exact != NULL)
        status = qcOperation_Apply(operation, run->exact, NULL);
    return status == qc_statusOk ? qc_exitDone : Fail(run, status, "");
}

static qcExitStatus ApplyAll(Run* run)
{
    for (;;)
    {
        const qcOperation* operation;
        qcStatus status = qcRecording_Next(run->recording, &operation);
        if (status != qc_statusOk)
            return Fail(run, status, "");
        run->totals->isUnclosed = operation->kind == qc_operationEnd && !operation->isComplete;
        if (operation->kind == qc_operationEnd)
            return qc_exitDone;
        run->totals->operations++;
        qcExitStatus ending = Apply(run, operation);
        if (ending != qc_exitDone)
            return ending;
        run->totals->isInterrupted = qcInterrupt_Signal() != 0;
        if (run->totals->isInterrupted || run->totals->detections == run->options->to)
            return qc_exitDone;
    }
}

qcExitStatus qcReplay_Run(const qcReplayOptions* options, qcRecording* recording, qcDevice* device,
                          qcDetectionFunction* function, void* context, qcReplayTotals* totals, qcMessage* message)
{
    *totals = (qcReplayTotals){0};
    Run run = {options, recording, NULL, NULL, function, context, totals, message};
    qcSceneDef def = qcDefaultSceneDef();
    def.device = device;
    qcStatus status = qcScene_Create(&def, &run.scene);
    def.device = NULL;
    if (status == qc_statusOk)
        status = qcScene_Create(&def, &run.exact);
    qcProgress_Begin(0, "replaying");
    qcExitStatus ending = status == qc_statusOk ? ApplyAll(&run) : Fail(&run, status, "");
    qcProgress_End();
    qcScene_Destroy(run.exact);
    qcScene_Destroy(run.scene);
    return ending;
}
