// The command line of `qc-bench scaling`.
#include "bench/scaling/scaling.h"

#include "common/options.h"

static const char s_help[] =
    "Time and memory against size. A folded cloth with itself by sweep, each step with new vertices: time, its stages, "
    "bytes of the library a triangle, and the exponent of the growth from 20 K to 1 M. Boxes of which 0, 1, 10 and "
    "100 % move: time of a step, in which those that move are moved and the pairs they take part in are found.\v"
    "Exit status: as for qc-bench.";

void qcScaling_ReadOptions(int argumentCount, char** arguments, qcScalingOptions* options)
{
    *options = (qcScalingOptions){
        .maxTriangles = 4000000, .maxBoxes = 200000, .threads = {1, 2}, .threadsCount = 2, .out = "out/bench"};
    const qcOption rows[] = {
        {1, "triangles", "N", "Cloths of 1000 triangles up to this many; %s by default, 0: none",
         qcOption_Number(&options->maxTriangles, 0, UINT32_MAX)},
        {1, "boxes", "N", "Sets of 100 boxes up to this many; %s by default, 0: none",
         qcOption_Number(&options->maxBoxes, 0, UINT32_MAX)},
        {1, "threads", "LIST", "Numbers of threads for the cloths; %s by default",
         qcOption_Numbers(options->threads, &options->threadsCount, qc_maxScalingThreads, 1, 1024, true)},
        {2, "out", "FOLDER",
         "Where scaling_meshes.csv, scaling_boxes.csv, scaling.gp and the picture go; %s by default, made if it is "
         "missing",
         qcOption_Folder(&options->out)},
        {0}};
    qcCommandLine line = {.options = rows, .help = s_help};
    qcCommandLine_Parse(&line, argumentCount, arguments);
}
