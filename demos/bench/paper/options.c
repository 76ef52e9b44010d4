// The command line of `qc-bench paper`.
#include "bench/paper/paper.h"

#include "common/options.h"

#include <string.h>

static const char s_help[] =
    "Section 5 of the paper: its scenes, recorded once, replayed for each method at the paper's resolution and views. "
    "Tables 1 (size of the potentially colliding set) and 2 (time), beside the paper's own values, the pairs that each "
    "method misses, figures 7 and 8 for each scene, and the factors of section 5.1.3. A scene whose recording is "
    "missing is skipped; \"demos/run.sh bench paper\" makes the recordings.\v"
    "cullide and quick run in some frames at equal distances, since they take seconds a frame without a GPU; the other "
    "methods run in all frames. The tables give the number of frames.\n\n"
    "Exit status: as for qc-bench; 1 also where a method that never misses missed; 3 where no recording was found.";

static void TakeFrames(const struct argp_state* state, const char* word, void* context)
{
    qcPaperOptions* options = context;
    options->allFrames = strcmp(word, "all") == 0;
    if (!options->allFrames)
        options->frames = qcOption_ReadNumber(state, "--frames", word, 1, 1000000);
}

void qcPaper_ReadOptions(int argumentCount, char** arguments, qcPaperOptions* options)
{
    *options = (qcPaperOptions){
        .rounds = 5, .resolution = 4096, .iterations = 2, .recordings = "out/recordings", .out = "out/bench"};
    qcWord parts[qc_paperPartCount + 1] = {{NULL, 0}};
    for (int i = 0; i < qc_paperSceneCount; ++i)
        parts[i] = (qcWord){qcPaperScenes[i].name, i};
    parts[qc_paperSceneCount] = (qcWord){"factors", qc_paperSceneCount};
    const qcOption rows[] = {
        {.group = 1, .help = "What is measured:"},
        {1, "parts", "LIST", "Of cloth, cloth-without (self-collision), breaking, leaves, factors; all by default",
         qcOption_Marks(options->parts, qc_paperPartCount, parts)},
        {1, "frames", "N|all", "Frames of cullide and quick; by default as many as take some minutes on two cores",
         qcOption_Texts(TakeFrames, options)},
        {.group = 2, .help = "How it is measured:"},
        {2, "resolution", "N", "Pixels on a side for cullide and quick; %s by default, as in the paper",
         qcOption_Number(&options->resolution, 1, 4096)},
        {2, "iterations", "N", "Rounds of cullide and quick over the views; %s by default, 0: until nothing changes",
         qcOption_Number(&options->iterations, 0, UINT32_MAX)},
        {2, "rounds", "N", "Times that each other method goes through a recording; %s by default, the median counts",
         qcOption_Number(&options->rounds, 1, qc_maxPaperRounds)},
        {2, "threads", "N", "Threads; 0, the default: one per core", qcOption_Number(&options->threads, 0, 1024)},
        {2, "device", "DEVICE",
         "auto (the default), egl (a GPU), osmesa or surfaceless (software), or none (cullide, quick and layers are "
         "left out)",
         qcOption_Device(&options->device)},
        {.group = 3, .help = "Files:"},
        {3, "recordings", "FOLDER", "Where cloth.qcr and the others are; %s by default",
         qcOption_Folder(&options->recordings)},
        {3, "out", "FOLDER", "Where paper.csv, paper.gp and the pictures go; %s by default, made if it is missing",
         qcOption_Folder(&options->out)},
        {0}};
    qcCommandLine line = {.options = rows, .help = s_help};
    qcCommandLine_Parse(&line, argumentCount, arguments);
}
