// The command line of `qc-bench first`.
#include "bench/first/first.h"

#include "common/options.h"

static const char s_help[] =
    "The first steps of new bodies, beside later ones and beside Embree's build and query, where Embree was installed "
    "when this was built. A step is new positions in, pairs out; a step of the column 'new' also removes all bodies "
    "and "
    "adds others, whose triangles connect other vertices in each step.\v"
    "The environment variable QC_KERNELS (plain, avx2, avx512) chooses our instruction set.\n\n"
    "Exit status: as for qc-bench; 1 also where two steps find different pairs in one frame.";

void qcFirst_ReadOptions(int argumentCount, char** arguments, qcFirstOptions* options)
{
    *options = (qcFirstOptions){.threads = {1, 2},
                                .threadsCount = 2,
                                .steps = 40,
                                .rounds = 5,
                                .models = {.bunny = QC_BUNNY_PATH},
                                .out = "out/bench"};
    qcWord scenes[qc_peerSceneRecipes + 2] = {{"all", -1}};
    for (int i = 0; i < qc_peerSceneRecipes; ++i)
        scenes[i + 1] = (qcWord){qcPeerScene_Name(i), i};
    const qcOption rows[] = {
        {.group = 1, .help = "What is tried:"},
        {1, "scenes", "LIST",
         "Scenes of \"qc-bench peers\", all by default; or cloth-20m, a folded cloth of 20 million triangles, no part "
         "of \"all\": 3 GiB and a minute with --threads 1 --steps 4 --rounds 1, without Embree",
         qcOption_Marks(options->scenes, qc_peerSceneCount, scenes)},
        {.group = 2, .help = "How it is measured:"},
        {2, "threads", "LIST", "Numbers of threads; %s by default",
         qcOption_Numbers(options->threads, &options->threadsCount, qc_maxPeerThreads, 1, 1024, true)},
        {2, "steps", "N", "Steps of a body's life, 4 to 64; %s by default",
         qcOption_Number(&options->steps, qc_firstMinSteps, qc_firstMaxSteps)},
        {2, "rounds", "N", "Lives, in turns with Embree; %s by default",
         qcOption_Number(&options->rounds, 1, qc_firstMaxRounds)},
        {.group = 3, .help = "Files:"},
        {3, "bunny", "FILE", "The model of the bunnies; that of the package glmark2-data by default",
         qcOption_Text(&options->models.bunny)},
        {3, "dragon", "FILE", "The model of dragon, which is skipped without it; tests/dragon.sh fetches it",
         qcOption_Text(&options->models.dragon)},
        {3, "out", "FOLDER", "Where first.csv goes; %s by default, made if it is missing",
         qcOption_Folder(&options->out)},
        {0}};
    qcCommandLine line = {.options = rows, .help = s_help};
    qcCommandLine_Parse(&line, argumentCount, arguments);
}
