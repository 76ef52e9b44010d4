// Types and functions of `qc-bench first`: what the first steps of a new mesh cost, and steps with a new topology each.
#ifndef QC_DEMOS_BENCH_FIRST_FIRST_H
#define QC_DEMOS_BENCH_FIRST_FIRST_H

#include "bench/peers/peers.h"

enum
{
    qc_firstMinSteps = 4,
    qc_firstMaxSteps = 64,
    qc_firstMaxRounds = 16
};

typedef struct qcFirstOptions
{
    bool scenes[qc_peerSceneRecipes];
    uint32_t threads[qc_maxPeerThreads];
    uint32_t threadsCount;
    uint32_t steps, rounds;
    qcBenchModels models;
    const char* out;
} qcFirstOptions;

/// Reads the command line; ends the program after --help and on a mistake.
void qcFirst_ReadOptions(int argumentCount, char** arguments, qcFirstOptions* options);

/// A scene with a number of threads: medians over the rounds, in milliseconds.
typedef struct qcFirstRow
{
    int scene;
    uint32_t triangleCount, threads;
    double addMs;                      ///< bodies in
    double firstMs, secondMs, thirdMs; ///< positions in, pairs out
    double longestMs;                  ///< of the steps after the first
    double steadyMs;                   ///< the median of the last quarter of the steps
    double newMs;    ///< a step with a new topology: bodies of the step before out, new ones in, pairs out
    double embreeMs; ///< Embree's build and query, the quicker of its two ways to build; 0: it was not built
    uint64_t pairs;  ///< in the first frame
    bool agrees;     ///< each step finds the pairs that the others, and Embree, find in this frame
} qcFirstRow;

/// False with a message: out of memory, or a step failed. `embree`: null where it was not built.
bool qcFirst_Measure(const qcFirstOptions* options, const qcAnimation* animation, const qcPeerLibrary* embree,
                     uint32_t threads, qcFirstRow* row, qcMessage* message);

/// Prints a row; before the first one, a heading.
void qcFirst_PrintRow(const qcFirstRow* row, bool isFirst);
bool qcFirst_WriteCsv(const qcFirstOptions* options, const qcFirstRow* rows, uint32_t rowCount, qcMessage* message);

#endif
