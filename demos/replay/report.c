// What qc-replay prints.
#include "replay/replay.h"

#include "common/stopwatch.h"

#include <inttypes.h>
#include <string.h>

//  ---- --list ------------------------------------------------------------------------------------------------------

static void PrintDef(const qcOperation* operation)
{
    const qcDetectDef* def = &operation->detect;
    printf(" by %s", qcMethod_Name(def->method));
    if (def->margin > 0.0)
        printf(", margin %.9g", def->margin);
    if (def->contactMargin > 0.0)
        printf(", contact margin %.9g", def->contactMargin);
    const struct
    {
        bool isSet;
        const char* name;
    } flags[] = {{def->touching, "touching"},       {def->neighbours, "neighbours"}, {def->segments, "segments"},
                 {def->proximities, "proximities"}, {def->manifolds, "manifolds"},   {def->motion, "motion"},
                 {def->reliable, "reliable"}};
    for (size_t i = 0; i < sizeof flags / sizeof flags[0]; i++)
        if (flags[i].isSet)
            printf(", %s", flags[i].name);
    if (def->pairFilter != NULL)
        printf(", a filter that rejected %zu pairs of bodies", operation->rejectedPairCount);
    if (!operation->hasResult)
        printf(": the recording ends in it");
    else if (operation->resultStatus != qc_statusOk)
        printf(": failed, %s", qcStatus_Name(operation->resultStatus));
    else
        printf(": %" PRIu64 " pairs, %" PRIu64 " contacts, %" PRIu64 " manifold points",
               operation->resultHash.pairCount, operation->resultHash.contactCount,
               operation->resultHash.manifoldPointCount);
}

static void PrintOperation(const qcOperation* o)
{
    static const char* activities[] = {"moving", "sleeping", "static"};
    printf("%8" PRIu64 " %12" PRIu64 "  %s", o->number, o->byteOffset, qcOperationKind_Name(o->kind));
    if (o->kind != qc_operationMarkStart && o->kind != qc_operationDetect && o->kind != qc_operationEnd)
        printf(" %" PRIu32, o->id.slot);
    switch (o->kind)
    {
        case qc_operationAddBody:
            printf(": %" PRIu32 " triangles, %" PRIu32 " vertices, %s, %s", o->body.triangleCount, o->body.vertexCount,
                   o->body.positionType == qc_positionF64 ? "double" : "float",
                   o->body.deforming ? "deforming" : "rigid");
            break;
        case qc_operationSetTransform:
            printf(": to %.9g %.9g %.9g", o->transform.translation[0], o->transform.translation[1],
                   o->transform.translation[2]);
            break;
        case qc_operationSetVertices:
            printf(": %" PRIu32 ", %s", o->vertexCount, o->positionType == qc_positionF64 ? "double" : "float");
            break;
        case qc_operationSetActivity:
            printf(": %s", (unsigned)o->activity < 3 ? activities[o->activity] : "unknown");
            break;
        case qc_operationSetFilter: printf(": group 0x%" PRIx32 ", mask 0x%" PRIx32, o->group, o->mask); break;
        case qc_operationSetSelfCollision: printf(": %s", o->selfCollision ? "on" : "off"); break;
        case qc_operationSetMargin: printf(": %.9g", o->margin); break;
        case qc_operationDetect: PrintDef(o); break;
        case qc_operationEnd: printf("%s", o->isComplete ? "" : ": the program ended without closing it"); break;
        case qc_operationRemoveBody:
        case qc_operationMarkStart: break;
    }
    putchar('\n');
}

qcExitStatus qcReplay_List(const qcReplayOptions* options, qcRecording* recording, qcMessage* message)
{
    (void)options;
    printf("operation      at byte\n");
    const qcOperation* operation;
    do
    {
        qcStatus status = qcRecording_Next(recording, &operation);
        if (status != qc_statusOk)
        {
            qcMessage_Fail(message, "%s", qcLastMessage());
            return status == qc_statusOutOfMemory ? qc_exitFailed : qc_exitBadInput;
        }
        PrintOperation(operation);
    } while (operation->kind != qc_operationEnd);
    return qc_exitDone;
}

//  ---- detections --------------------------------------------------------------------------------------------------

void qcReplay_PrintHeading(const qcReplayOptions* options, const qcRecording* recording, const qcDevice* device)
{
    qcRecordingInfo info = qcRecording_GetInfo(recording);
    qcDeviceInfo own = {.name = "none", .renderer = ""};
    if (device != NULL)
        qcDevice_GetInfo(device, &own);
    printf("%s: recorded by version %u.%u.%u, device %s\n", options->path, info.libraryVersion / 10000,
           info.libraryVersion / 100 % 100, info.libraryVersion % 100, info.device);
    printf("method %s, device %s%s%s\n", options->methodName, own.name, own.renderer[0] != 0 ? ", " : "", own.renderer);
}

void qcReplay_PrintColumns(void)
{
    printf("detection  operation  method         ms      pairs   contacts     points  result\n");
}

static void PrintVerdict(FILE* stream, const qcDetection* d)
{
    switch (d->verdict)
    {
        case qc_verdictSame: fputs("same", stream); break;
        case qc_verdictDiffers: fprintf(stream, "DIFFERS in %s", d->reason); break;
        case qc_verdictNotCompared: fprintf(stream, "not compared: %s", d->reason); break;
        case qc_verdictNoneMissed: fputs("none missed", stream); break;
        case qc_verdictMissed: fprintf(stream, "misses %" PRIu64 " of %" PRIu64, d->missed, d->recordedPairs); break;
    }
}

void qcReplay_PrintDetection(const qcDetection* d)
{
    printf("%9" PRIu64 " %10" PRIu64 "  %-7s %9.3f %10" PRIu64 " %10" PRIu64 " %10" PRIu64 "  ", d->number,
           d->operation, qcMethod_Name(d->method), d->ms, d->pairs, d->contacts, d->points);
    PrintVerdict(stdout, d);
    if (d->verdict == qc_verdictDiffers && d->pairs != d->recordedPairs)
        printf(" (%" PRIu64 " pairs were recorded)", d->recordedPairs);
    putchar('\n');
}

void qcReplay_PrintTotals(const qcReplayOptions* options, qcReplayTotals* totals)
{
    double sum = 0.0, max = 0.0;
    for (size_t i = 0; i < totals->timeCount; i++)
    {
        sum += totals->times[i];
        max = totals->times[i] > max ? totals->times[i] : max;
    }
    double median = qcStopwatch_Median(totals->times, totals->timeCount);
    printf("%" PRIu64 " operations, %zu detections replayed", totals->operations, totals->timeCount);
    if (totals->timeCount != 0)
        printf(" in %.1f ms (median %.3f, max %.3f), %" PRIu64 " pairs", sum, median, max, totals->pairs);
    putchar('\n');
    if (totals->fallback != NULL)
        printf("another method ran in place of %s: %s\n", options->methodName, totals->fallback);
    if (totals->sampled != 0)
        printf("missed: %" PRIu64 " of %" PRIu64 " pairs, in %" PRIu64 " detections by a method that samples; margins, "
               "contacts and motions are left out\n",
               totals->missedPairs, totals->exactPairs, totals->sampled);
    if (totals->same + totals->differing != 0)
        printf("%" PRIu64 " results are the recorded ones, %" PRIu64 " differ\n", totals->same, totals->differing);
    if (totals->notCompared != 0)
        printf("%" PRIu64 " results were not compared; --each gives the reasons\n", totals->notCompared);
    if (totals->isInterrupted)
        printf("interrupted\n");
}

//  ---- CSV ---------------------------------------------------------------------------------------------------------

void qcReplay_WriteCsvHead(FILE* stream)
{
    fprintf(stream,
            "detection,operation,method,milliseconds,pairs,contacts,manifold points,expected pairs,missed,result\n");
}

void qcReplay_WriteCsvLine(FILE* stream, const qcDetection* d)
{
    fprintf(stream, "%" PRIu64 ",%" PRIu64 ",%s,%.6f,%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",\"",
            d->number, d->operation, qcMethod_Name(d->method), d->ms, d->pairs, d->contacts, d->points,
            d->recordedPairs, d->missed);
    PrintVerdict(stream, d);
    fputs("\"\n", stream);
}
