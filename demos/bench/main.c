// qc-bench: the benchmarks, one a subcommand.
#include "bench/bench.h"

#include "common/options.h"

#include <argp.h>
#include <stdio.h>
#include <string.h>

typedef struct Benchmark
{
    const char* name;
    char* called; ///< in messages and in its help
    qcExitStatus (*run)(int argumentCount, char** arguments);
} Benchmark;

static const Benchmark s_benchmarks[] = {
    // clang-format off
    {"accuracy", "qc-bench accuracy", qcBench_RunAccuracy},
    {"peers", "qc-bench peers", qcBench_RunPeers},
    {"first", "qc-bench first", qcBench_RunFirst},
    {"scaling", "qc-bench scaling", qcBench_RunScaling},
    {"gpu", "qc-bench gpu", qcBench_RunGpu},
    {"paper", "qc-bench paper", qcBench_RunPaper},
// clang-format on
#ifdef QC_HAS_BULLET
    {"broadphase", "qc-bench broadphase", qcBench_RunBroadphase},
    {"queries", "qc-bench queries", qcBench_RunQueries},
    {"terrain", "qc-bench terrain", qcBench_RunTerrain},
    {"soft", "qc-bench soft", qcBench_RunSoft},
    {"through", "qc-bench through", qcBench_RunThrough},
    {"stability", "qc-bench stability", qcBench_RunStability},
    {"piles", "qc-bench piles", qcBench_RunPiles},
#endif
#ifdef QC_HAS_FRACTURE
    {"fracture", "qc-bench fracture", qcBench_RunFracture},
#endif
};

enum
{
    qc_benchmarkCount = sizeof s_benchmarks / sizeof s_benchmarks[0]
};

typedef struct Choice
{
    const Benchmark* benchmark;
    int first; ///< argument that names it
} Choice;

static void Choose(const struct argp_state* state, const char* name, Choice* choice)
{
    char known[256] = "";
    for (int i = 0; i < qc_benchmarkCount; ++i)
    {
        if (strcmp(s_benchmarks[i].name, name) == 0)
            choice->benchmark = &s_benchmarks[i];
        size_t length = strlen(known);
        snprintf(known + length, sizeof known - length, "%s%s", i == 0 ? "" : ", ", s_benchmarks[i].name);
    }
    if (choice->benchmark == NULL)
        argp_error(state, "there is no benchmark '%s', only: %s", name, known);
    choice->first = state->next - 1;
}

static error_t ReadOption(int key, char* text, struct argp_state* state)
{
    switch (key)
    {
        case ARGP_KEY_ARG:
            Choose(state, text, state->input);
            // The rest is the benchmark's own.
            state->next = state->argc;
            return 0;
        case ARGP_KEY_NO_ARGS: argp_error(state, "no BENCHMARK is named"); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

static const char s_help[] =
    // Lines of the list fit 79 columns: argp would break longer ones without indenting.
    "Measures the methods of the library against each other, against other libraries, and against size.\n\n"
    "  accuracy   run time against error over scenes with known answers\n"
    "  peers      run time beside Embree, Bullet and CGAL, on the same meshes\n"
    "  first      the first steps of new meshes, beside Embree's build and query\n"
    "  scaling    1 K to 4 M triangles and 100 to 200 K boxes: run time, memory\n"
    "  gpu        layers on a GL device beside sweep, each kernel timed\n"
    "  paper      the scenes, tables and figures of the paper's section 5\n"
    "  broadphase moving boxes inside Bullet, beside its own broadphases\n"
    "  queries    rays, sweeps and boxes on static meshes, beside Bullet's\n"
    "  terrain    convex bodies on hills of triangles, beside Bullet alone\n"
    "  soft       hard scenes of cloth, tangles and ropes, beside Bullet alone\n"
    "  through    bodies thrown so fast that they could pass each other\n"
    "  stability  long runs of scenes that come to rest: energy, depth, memory\n"
    "  piles      small meshes that fall on each other, beside Bullet's shapes\n"
    "  fracture   a mesh that breaks into hundreds of pieces, beside convex hulls"
    "\v\"qc-bench BENCHMARK --help\" lists the options of one.\n\n"
    "Exit status: 0 done; 1 output could not be written, out of memory, or a method that never misses missed; 2 a "
    "mistake on the command line; 3 a model or recording can't be read; 4 the device does not work here; 5 no peer "
    "library was there when this was built; 130 ended by Ctrl-C.";

int main(int argumentCount, char** arguments)
{
    static const struct argp parser = {NULL, ReadOption, "BENCHMARK [OPTION...]", s_help, NULL, NULL, NULL};
    Choice choice = {NULL, 0};
    qcCommandLine_Begin(arguments);
    argp_parse(&parser, argumentCount, arguments, ARGP_IN_ORDER, NULL, &choice);
    arguments[choice.first] = choice.benchmark->called;
    return (int)choice.benchmark->run(argumentCount - choice.first, arguments + choice.first);
}
