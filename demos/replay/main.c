// qc-replay: runs a recording again, and compares its results with the recorded ones.
#define _GNU_SOURCE // unsetenv, program_invocation_short_name
#include "replay/replay.h"

#include "common/device.h"
#include "common/interrupt.h"
#include "common/output_file.h"
#include "common/progress.h"

#include <errno.h>
#include <stdlib.h>

/// What is done with each detection.
typedef struct Report
{
    const qcReplayOptions* options;
    FILE* csv;        ///< or null
    uint64_t printed; ///< lines of detections that differ
    bool hasColumns;
} Report;

static void ReportDetection(const qcDetection* detection, void* context)
{
    Report* report = context;
    if (report->csv != NULL)
        qcReplay_WriteCsvLine(report->csv, detection);
    bool differs = detection->verdict == qc_verdictDiffers && ++report->printed <= qc_maxDifferences;
    if (!report->options->each && !differs)
        return;
    qcProgress_End();
    if (!report->hasColumns)
        qcReplay_PrintColumns();
    report->hasColumns = true;
    qcReplay_PrintDetection(detection);
}

static qcExitStatus OpenDevice(const qcReplayOptions* options, qcDevice** device, qcMessage* message)
{
    bool draws =
        options->method == qc_methodQuick || options->method == qc_methodCullide || options->method == qc_methodLayers;
    if (!draws && options->deviceName == NULL)
        return qc_exitDone;
    qcDeviceDef def = qcDefaultDeviceDef();
    qcDeviceInfo info;
    def.kind = options->device;
    return qcToolDevice_Open(&def, device, &info, message);
}

static qcExitStatus Replay(const qcReplayOptions* options, qcRecording* recording, qcDevice* device, qcMessage* message)
{
    Report report = {.options = options};
    qcOutput output = {0};
    if (options->csv != NULL && !qcOutput_Open(options->csv, &output, message))
        return qc_exitFailed;
    report.csv = output.stream;
    qcReplay_PrintHeading(options, recording, device);
    qcReplayTotals totals;
    qcExitStatus ending;
    if (qcRecording_GetInfo(recording).boxScalarSize != 0)
        ending = qcReplay_RunBoxes(options, recording, report.csv, &totals, message);
    else
    {
        if (report.csv != NULL)
            qcReplay_WriteCsvHead(report.csv);
        ending = qcReplay_Run(options, recording, device, ReportDetection, &report, &totals, message);
    }
    qcReplay_PrintTotals(options, &totals);
    free(totals.times);
    if (report.csv != NULL && !qcOutput_Commit(&output, message))
        return qc_exitFailed;
    if (ending == qc_exitDone && totals.isInterrupted)
        return qcInterrupt_ExitStatus();
    if (ending == qc_exitDone && totals.timeCount == 0 && options->from > 1)
    {
        qcMessage_Fail(message, "--from %u: the recording has fewer detections", options->from);
        return qc_exitUsage;
    }
    if (ending == qc_exitDone && totals.differing != 0)
    {
        qcMessage_Fail(message, "%llu of %zu results differ from the recorded ones",
                       (unsigned long long)totals.differing, totals.timeCount);
        return qc_exitFailed;
    }
    return ending;
}

static qcExitStatus Run(const qcReplayOptions* options, qcMessage* message)
{
    qcRecording* recording = NULL;
    qcDevice* device = NULL;
    qcStatus status = qcRecording_Open(options->path, &recording);
    if (status != qc_statusOk)
    {
        qcMessage_Fail(message, "%s", qcLastMessage());
        return status == qc_statusOutOfMemory ? qc_exitFailed : qc_exitBadInput;
    }
    qcExitStatus ending = qc_exitDone;
    if (options->list)
        ending = qcReplay_List(options, recording, message);
    else
    {
        ending = OpenDevice(options, &device, message);
        if (ending == qc_exitDone)
            ending = Replay(options, recording, device, message);
    }
    qcDevice_Destroy(device);
    qcRecording_Close(recording);
    return ending;
}

int main(int argumentCount, char** arguments)
{
    qcReplayOptions options;
    qcReplay_ReadOptions(argumentCount, arguments, &options);
    // Meant for the program that is recorded.
    unsetenv("QC_RECORD");
    qcInterrupt_Watch();
    qcMessage message = {""};
    qcExitStatus ending = Run(&options, &message);
    if (message.text[0] != 0)
        fprintf(stderr, "%s: %s\n", program_invocation_short_name, message.text);
    return (int)ending;
}
