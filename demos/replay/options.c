// The command line of qc-replay.
#include "replay/replay.h"

#include "common/options.h"

#include <stdlib.h>
#include <string.h>

static const qcWord s_methods[] = {{"recorded", qc_recordedMethod}, {"brute", qc_methodBrute},
                                   {"sweep", qc_methodSweep},       {"layers", qc_methodLayers},
                                   {"quick", qc_methodQuick},       {"cullide", qc_methodCullide},
                                   {"auto", qc_methodAuto},         {NULL, 0}};

/// The first option that has no effect with --list, or null.
static const char* FindUnused(const qcReplayOptions* options)
{
    const struct
    {
        const char* name;
        bool isSet;
    } rows[] = {{"--csv", options->csv != NULL},
                {"--each", options->each},
                {"--from", options->from != 1},
                {"--to", options->to != UINT32_MAX},
                {"--method", options->method != qc_recordedMethod},
                {"--threads", options->threads != qc_recordedThreads},
                {"--device", options->deviceName != NULL}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        if (rows[i].isSet)
            return rows[i].name;
    return NULL;
}

static void CheckTogether(const struct argp_state* state, void* context)
{
    qcReplayOptions* options = context;
    options->method = qcOption_ReadWord(state, "--method", options->methodName, s_methods);
    if (options->deviceName != NULL)
        options->device = (qcDeviceKind)qcOption_ReadWord(state, "--device", options->deviceName, qcDeviceWords);
    const char* unused = options->list ? FindUnused(options) : NULL;
    if (unused != NULL)
        argp_error(state, "%s: --list replays nothing", unused);
    if (options->csv != NULL && strcmp(options->csv, "-") == 0)
        argp_error(state, "--csv: the report has standard output; name a file");
    if (options->from > options->to)
        argp_error(state, "--from: %u lies behind --to, %u", options->from, options->to);
}

static const char s_help[] =
    "Replays a recording of a scene or a broadphase: qcScene_Record, qcBroadphase::record or QC_RECORD=PREFIX in the "
    "environment of any program writes it. The results are compared with the recorded ones by their hashes. Methods "
    "that sample (quick, cullide) find the intersecting pairs only, and are compared with the sweep: the pairs that "
    "they miss are counted. A broadphase is replayed by another qcBroadphase (recorded) or by brute force (brute); one "
    "of Bullet in double precision by qc-replay-double.\v"
    "Exit status: 0 all results are the recorded ones; 1 some differ, or output could not be written; 2 a mistake on "
    "the command line; 3 the recording can't be read, is a broadphase of the other precision, or is damaged: what lies "
    "before the damage is replayed; 4 the device does not work here; 130 ended by Ctrl-C, with a report of what was "
    "done.";

void qcReplay_ReadOptions(int argumentCount, char** arguments, qcReplayOptions* options)
{
    *options = (qcReplayOptions){.methodName = "recorded", .threads = qc_recordedThreads, .from = 1, .to = UINT32_MAX};
    const qcOption rows[] = {
        {1, "method", "METHOD",
         "recorded (the default), brute, sweep, layers, quick (Quick-CULLIDE), cullide (CULLIDE) or auto",
         qcOption_Text(&options->methodName)},
        {1, "threads", "N", "Threads; 0: one per core. By default as recorded",
         qcOption_Number(&options->threads, 0, qc_maxThreads)},
        {1, "device", "DEVICE",
         "What layers, quick and cullide draw with: auto (the default), egl (a GPU), osmesa or surfaceless (software), "
         "or none (sweep then answers for them)",
         qcOption_Text(&options->deviceName)},
        {1, "from", "N", "The first detection to run; they count from 1",
         qcOption_Number(&options->from, 1, UINT32_MAX)},
        {1, "to", "N", "The last detection to run; by default all", qcOption_Number(&options->to, 1, UINT32_MAX)},
        {.group = 2, .help = "Output:"},
        {2, "each", NULL, "Print a line for each detection, not only for those that differ",
         qcOption_Flag(&options->each, true)},
        {2, "list", NULL, "Print the operations, and replay nothing", qcOption_Flag(&options->list, true)},
        {2, "csv", "FILE", "Write a line for each detection: times, counts, what differs",
         qcOption_Text(&options->csv)},
        {0},
    };
    qcCommandLine line = {
        .options = rows, .help = s_help, .arguments = "FILE", .complete = CheckTogether, .context = options};
    qcCommandLine_Parse(&line, argumentCount, arguments);
    if (line.pathCount > 1)
    {
        fprintf(stderr, "%s: one recording at a time, please: '%s' follows\n", arguments[0], line.paths[1]);
        exit(qc_exitUsage);
    }
    options->path = line.paths[0];
    qcCommandLine_KeepFiles(&line, arguments[0], "--csv", options->csv);
}
