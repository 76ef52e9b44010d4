// Replays a broadphase: each search and query is compared with what was recorded.
#include "replay/box_replay.h"
#include "replay/replay.h"

#include "common/interrupt.h"
#include "common/stopwatch.h"

#include <algorithm>
#include <cinttypes>
#include <cstring>
#include <string>
#include <unordered_set>

namespace
{
struct BoxRun
{
    const qcReplayOptions* options;
    FILE* csv;
    qcReplayTotals* totals;
    qcMessage* message;
    qcBoxReplay* replay;
    qcBoxReplay* oracle; ///< brute force: what casts have to report
    std::unordered_set<uint32_t> ids;
    uint64_t printed = 0;
    double ms = 0.0; ///< of the search or query
};

bool FailAt(BoxRun& run, const qcOperation& o, const char* what, uint32_t id)
{
    return qcMessage_Fail(run.message, "%s: operation %" PRIu64 " at byte %" PRIu64 ": box %" PRIu32 " %s",
                          run.options->path, o.number, o.byteOffset, id, what);
}

//  ---- comparison ------------------------------------------------------------------------------------

bool HaveAll(const std::vector<uint32_t>& reported, const std::vector<uint32_t>& hits)
{
    std::unordered_set<uint32_t> all(reported.begin(), reported.end());
    return std::all_of(hits.begin(), hits.end(), [&](uint32_t id) { return all.count(id) != 0; });
}

qcVerdict CompareCast(BoxRun& run, const qcBoxOperation& boxes, std::string& reason, uint64_t& found)
{
    std::vector<uint32_t> recorded(boxes.ids, boxes.ids + boxes.count), hits = run.oracle->Cast(boxes), ids = hits;
    bool isBrute = run.replay == run.oracle;
    double start = qcStopwatch_NowMs();
    if (!isBrute)
        ids = run.replay->Cast(boxes);
    run.ms = qcStopwatch_NowMs() - start;
    found = ids.size();
    if (!HaveAll(recorded, hits) || !HaveAll(ids, hits))
    {
        reason = "boxes that are hit";
        return qc_verdictDiffers;
    }
    if (isBrute || ids == recorded)
        return qc_verdictSame;
    reason = "other boxes near the path were reported";
    return qc_verdictNotCompared;
}

qcVerdict CompareAnswer(BoxRun& run, const qcOperation& o, std::string& reason, uint64_t& found)
{
    const qcBoxOperation& boxes = o.boxes;
    if (o.kind == qc_operationCastBox)
        return CompareCast(run, boxes, reason, found);
    double start = qcStopwatch_NowMs();
    if (o.kind == qc_operationQueryBox)
    {
        std::vector<uint32_t> ids = run.replay->Query(boxes.bounds);
        run.ms = qcStopwatch_NowMs() - start;
        found = ids.size();
        reason = "boxes";
        return ids == std::vector<uint32_t>(boxes.ids, boxes.ids + boxes.count) ? qc_verdictSame : qc_verdictDiffers;
    }
    std::vector<qcBoxPair> pairs = run.replay->FindPairs(boxes);
    run.ms = qcStopwatch_NowMs() - start;
    found = pairs.size();
    run.totals->pairs += found;
    reason = "pairs";
    bool isSame = pairs.size() == boxes.pairCount && qcBoxPairs_Hash(pairs.data(), pairs.size()) == boxes.pairHash;
    return isSame ? qc_verdictSame : qc_verdictDiffers;
}

void Report(BoxRun& run, const qcDetection& d, const char* kind)
{
    if (run.csv != nullptr)
        std::fprintf(run.csv, "%" PRIu64 ",%" PRIu64 ",%s,%.6f,%" PRIu64 ",%" PRIu64 ",\"%s%s%s\"\n", d.number,
                     d.operation, kind, d.ms, d.pairs, d.recordedPairs, qcReplay_VerdictName(d.verdict),
                     d.reason[0] != 0 ? " " : "", d.reason);
    bool differs = d.verdict == qc_verdictDiffers && ++run.printed <= qc_maxDifferences;
    if (!run.options->each && !differs)
        return;
    if (run.totals->timeCount == 0 || (!run.options->each && run.printed == 1))
        std::printf("   number  operation  search           ms      found   recorded  result\n");
    std::printf("%9" PRIu64 " %10" PRIu64 "  %-10s %9.3f %10" PRIu64 " %10" PRIu64 "  %s %s\n", d.number, d.operation,
                kind, d.ms, d.pairs, d.recordedPairs, qcReplay_VerdictName(d.verdict), d.reason);
}

/// A search for pairs or a query.
bool Answer(BoxRun& run, const qcOperation& o)
{
    uint64_t number = ++run.totals->detections;
    if (number < run.options->from || number > run.options->to)
        return true;
    qcDetection d = {};
    std::string reason;
    d.number = number;
    d.operation = o.number;
    d.recordedPairs = o.kind == qc_operationFindPairs ? o.boxes.pairCount : o.boxes.count;
    d.verdict = CompareAnswer(run, o, reason, d.pairs);
    d.ms = run.ms;
    if (o.boxes.isDisturbed && d.verdict == qc_verdictDiffers)
    {
        d.verdict = qc_verdictNotCompared;
        reason = "a callback changed the boxes meanwhile";
    }
    if (d.verdict != qc_verdictSame)
        std::snprintf(d.reason, sizeof d.reason, "%s", reason.c_str());
    Report(run, d, qcOperationKind_Name(o.kind));
    if (qcReplay_Count(run.totals, &d))
        return true;
    return qcMessage_Fail(run.message, "out of memory");
}

//  ---- operations ------------------------------------------------------------------------------------

/// Calls apply(replay) for both, or for the one that is both.
template <class Apply> void ApplyToBoth(BoxRun& run, Apply apply)
{
    apply(*run.replay);
    if (run.oracle != run.replay)
        apply(*run.oracle);
}

bool ApplyChange(BoxRun& run, const qcOperation& o)
{
    const qcBoxOperation& b = o.boxes;
    for (size_t i = 0; i < b.count && o.kind != qc_operationAddBox; i++)
        if (run.ids.count(b.ids[i]) == 0)
            return FailAt(run, o, "is not there", b.ids[i]);
    switch (o.kind)
    {
        case qc_operationAddBox:
            if (!run.ids.insert(*b.ids).second)
                return FailAt(run, o, "is there already", *b.ids);
            ApplyToBoth(run, [&](qcBoxReplay& replay) { replay.Add(*b.ids, b.bounds, b.group, b.mask); });
            break;
        case qc_operationRemoveBox:
            run.ids.erase(*b.ids);
            ApplyToBoth(run, [&](qcBoxReplay& replay) { replay.Remove(*b.ids); });
            break;
        case qc_operationMoveBoxes:
            for (size_t i = 0; i < b.count; i++)
                ApplyToBoth(run, [&](qcBoxReplay& replay) { replay.Move(b.ids[i], b.bounds + 6 * i); });
            break;
        default: ApplyToBoth(run, [&](qcBoxReplay& replay) { replay.SetFilter(*b.ids, b.group, b.mask); }); break;
    }
    return true;
}

/// All boxes go. Bullet's broadphases reset only what is empty.
void ApplyReset(BoxRun& run)
{
    for (uint32_t id : run.ids)
        ApplyToBoth(run, [id](qcBoxReplay& replay) { replay.Remove(id); });
    run.ids.clear();
    ApplyToBoth(run, [](qcBoxReplay& replay) { replay.Reset(); });
}

bool Apply(BoxRun& run, const qcOperation& o)
{
    switch (o.kind)
    {
        case qc_operationFindPairs:
        case qc_operationQueryBox:
        case qc_operationCastBox: return Answer(run, o);
        case qc_operationResetBoxes: ApplyReset(run); return true;
        default: return ApplyChange(run, o);
    }
}

qcExitStatus ApplyAll(BoxRun& run, qcRecording* recording)
{
    for (;;)
    {
        const qcOperation* operation;
        qcStatus status = qcRecording_Next(recording, &operation);
        if (status != qc_statusOk)
        {
            qcMessage_Fail(run.message, "%s", qcLastMessage());
            return status == qc_statusOutOfMemory ? qc_exitFailed : qc_exitBadInput;
        }
        run.totals->isUnclosed = operation->kind == qc_operationEnd && !operation->isComplete;
        if (operation->kind == qc_operationEnd)
            return qc_exitDone;
        run.totals->operations++;
        if (!Apply(run, *operation))
            return qc_exitBadInput;
        run.totals->isInterrupted = qcInterrupt_Signal() != 0;
        if (run.totals->isInterrupted || run.totals->detections == run.options->to)
            return qc_exitDone;
    }
}
} // namespace

qcExitStatus qcReplay_RunBoxes(const qcReplayOptions* options, qcRecording* recording, FILE* csv,
                               qcReplayTotals* totals, qcMessage* message)
{
    *totals = qcReplayTotals{};
    uint32_t scalarSize = qcRecording_GetInfo(recording).boxScalarSize;
    std::unique_ptr<qcBoxReplay> oracle = qcMakeBruteBoxReplay(), replay;
    if (options->method == qc_recordedMethod)
        replay = qcMakeBroadphaseReplay(scalarSize);
    if (options->method != qc_methodBrute && replay == nullptr)
    {
        if (options->method != qc_recordedMethod)
        {
            qcMessage_Fail(message, "--method: a broadphase is replayed by recorded or brute");
            return qc_exitUsage;
        }
        qcMessage_Fail(message, "this program has no broadphase of %s precision; use %s, or --method brute",
                       scalarSize == sizeof(float) ? "single" : "double",
                       scalarSize == sizeof(float) ? "qc-replay" : "qc-replay-double");
        return qc_exitBadInput;
    }
    if (csv != nullptr)
        std::fprintf(csv, "number,operation,search,milliseconds,found,recorded,result\n");
    BoxRun run = {options, csv, totals, message, replay != nullptr ? replay.get() : oracle.get(), oracle.get(), {}};
    return ApplyAll(run, recording);
}
