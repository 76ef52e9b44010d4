// qc-bench broadphase: qcBroadphase inside Bullet, beside Bullet's own broadphases.
#include "bench/broadphase/broadphase.h"

#include "common/files.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "bench/bench.h"

#include <stdio.h>

enum
{
    qc_maxListed = 12
};

typedef struct List
{
    uint32_t values[qc_maxListed], count;
} List;

typedef struct Options
{
    List boxes, percents;
    uint32_t frames;
    const char* out;
} Options;

static const char s_help[] =
    "Boxes with edges of 1 to 2 that go 0.1 a frame, in a cube so dense that each overlaps about four others, in "
    "qcBroadphase, btDbvtBroadphase (as it is, and with m_deferedcollide), bt32BitAxisSweep3 (up to 10000 boxes) and "
    "btSimpleBroadphase (up to 500), each with its pair cache. A frame is setAabb, for the boxes that move or for "
    "all, "
    "as a Bullet world does it, and calculateOverlappingPairs; 'first' is the first call of the latter, after all "
    "boxes were "
    "created. The broadphases take turns frame by frame.\v"
    "Exit status: as for qc-bench; 1 too if qcBroadphase holds other pairs than those that overlap.";

static void PrintHead(const qcBroadphaseScene* scene, const qcBroadphaseResult* result)
{
    printf("\n%u boxes, %u %% moving, setAabb for %s; %u frames, %zu pairs overlap\n", scene->boxes, scene->percent,
           scene->setsAll ? "all" : "those", result->frames, result->expected);
    printf("%-26s %10s %10s %10s %10s %10s %10s %10s %7s %8s\n", "milliseconds", "frame", "least", "worst", "setAabb",
           "find", "create", "first", "ratio", "held");
}

static void PrintRows(const qcBroadphaseResult* result)
{
    for (uint32_t i = 0; i < result->count; i++)
    {
        const qcBroadphaseRow* row = &result->rows[i];
        printf("%-26s %10.4f %10.4f %10.4f %10.4f %10.4f %10.2f %10.2f %7.2f %8zu\n", row->name, row->frameMs,
               row->minMs, row->maxMs, row->setMs, row->findMs, row->createMs, row->firstMs,
               row->frameMs / result->rows[0].frameMs, row->held);
    }
    fflush(stdout);
}

static void WriteRows(FILE* stream, const qcBroadphaseScene* scene, const qcBroadphaseResult* result)
{
    for (uint32_t i = 0; i < result->count; i++)
    {
        const qcBroadphaseRow* row = &result->rows[i];
        fprintf(stream, "%u,%u,%s,", scene->boxes, scene->percent, scene->setsAll ? "all" : "movers");
        qcFiles_WriteQuoted(stream, row->name);
        fprintf(stream, ",%u,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%zu,%zu,%zu\n", result->frames, row->frameMs,
                row->minMs, row->maxMs, row->setMs, row->findMs, row->createMs, row->firstMs, row->held,
                row->overlapping, result->expected);
    }
}

/// qcBroadphase must hold exactly the pairs that overlap. Pairs that others miss are printed only.
static bool IsRight(const qcBroadphaseResult* result)
{
    for (uint32_t i = 0; i < result->count; i++)
        if (result->rows[i].overlapping != result->expected)
            printf("%s holds %zu of the %zu pairs that overlap\n", result->rows[i].name, result->rows[i].overlapping,
                   result->expected);
    return result->rows[0].held == result->expected && result->rows[0].overlapping == result->expected;
}

static bool MeasureAll(const Options* options, FILE* stream)
{
    bool right = true;
    qcBroadphaseScene scene = {.frames = options->frames};
    for (uint32_t i = 0; i < options->boxes.count; i++)
        for (uint32_t j = 0; j < options->percents.count; j++)
            // If all boxes move, both variants are the same.
            for (int all = options->percents.values[j] == 100; all <= 1; all++)
            {
                if (qcInterrupt_Signal() != 0)
                    return right;
                qcBroadphaseResult result;
                scene.boxes = options->boxes.values[i];
                scene.percent = options->percents.values[j];
                scene.setsAll = all;
                if (!qcBroadphase_Measure(&scene, &result))
                {
                    fprintf(stderr, "out of memory\n");
                    return false;
                }
                PrintHead(&scene, &result);
                PrintRows(&result);
                WriteRows(stream, &scene, &result);
                right = IsRight(&result) && right;
            }
    return right;
}

static bool Run(const Options* options, qcMessage* message)
{
    qcInterrupt_Watch();
    qcOutput output;
    if (!qcFiles_Check(options->out, "broadphase.csv", message) ||
        !qcFiles_Open(options->out, "broadphase.csv", &output, message))
        return false;
    fputs("boxes,percent,set,broadphase,frames,ms,least ms,worst ms,set ms,find ms,create ms,first ms,held,overlapping,"
          "expected\n",
          output.stream);
    if (!MeasureAll(options, output.stream))
    {
        qcOutput_Abort(&output);
        return qcMessage_Fail(message, "qcBroadphase holds other pairs than those that overlap, or memory ran out");
    }
    return qcOutput_Commit(&output, message);
}

qcExitStatus qcBench_RunBroadphase(int argumentCount, char** arguments)
{
    Options options = {{{1000, 10000, 50000}, 3}, {{0, 1, 10, 100}, 4}, 100, "out/bench"};
    const qcOption rows[] = {
        {1, "boxes", "LIST", "Numbers of boxes; %s by default",
         qcOption_Numbers(options.boxes.values, &options.boxes.count, qc_maxListed, 2, 1000000, false)},
        {1, "moving", "LIST", "Percentages of them that move; %s by default",
         qcOption_Numbers(options.percents.values, &options.percents.count, qc_maxListed, 0, 100, false)},
        {1, "frames", "N", "Frames of each scene at most; %s by default", qcOption_Number(&options.frames, 1, 100000)},
        {2, "out", "FOLDER", "Where broadphase.csv goes; %s by default, made if it is missing",
         qcOption_Folder(&options.out)},
        {0}};
    qcCommandLine line = {.options = rows, .help = s_help};
    qcCommandLine_Parse(&line, argumentCount, arguments);
    qcMessage message;
    if (Run(&options, &message))
        return qcInterrupt_ExitStatus();
    fprintf(stderr, "%s: %s\n", arguments[0], message.text);
    return qc_exitFailed;
}
