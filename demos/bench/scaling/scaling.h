// Types and functions of `qc-bench scaling`: the options, and a row for each size.
#ifndef QC_DEMOS_BENCH_SCALING_SCALING_H
#define QC_DEMOS_BENCH_SCALING_SCALING_H

#include "common/message.h"
#include "bench/bench.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum
{
    qc_scalingMeshSizes = 13,
    qc_scalingBoxSizes = 11,
    qc_scalingFractions = 4,
    qc_maxScalingThreads = 8 // different numbers of them
};

typedef struct qcScalingOptions
{
    uint32_t maxTriangles, maxBoxes; ///< larger sizes are left out
    uint32_t threads[qc_maxScalingThreads];
    uint32_t threadsCount;
    const char* out;
} qcScalingOptions;

/// Reads the command line; ends the program after --help and on a mistake.
void qcScaling_ReadOptions(int argumentCount, char** arguments, qcScalingOptions* options);

//  ---- meshes --------------------------------------------------------------------------------------

/// The stages of a step, in their order.
typedef enum qcScalingStage
{
    qc_stageVertices, ///< new vertices in
    qc_stageObjects,  ///< plan, culling and sweep of bodies
    qc_stageTriangles,
    qc_stageExact,
    qc_stageOther, ///< the rest of the step
    qc_scalingStageCount
} qcScalingStage;

/// "vertices"
const char* qcScalingStage_Name(qcScalingStage stage);

/// A folded cloth with itself.
typedef struct qcScalingMeshRow
{
    uint32_t triangles, threads;
    uint32_t steps;   ///< timed steps
    double ms, minMs; ///< new vertices in, pairs out: median and minimum
    double firstMs, secondMs;
    double stages[qc_scalingStageCount]; ///< medians
    double bytes;                        ///< memory of the library, per triangle
    uint64_t candidates, pairs;          ///< of the last step
} qcScalingMeshRow;

/// Number of sizes within the options' limit.
uint32_t qcScaling_CountMeshSizes(const qcScalingOptions* options);
/// Fills the rows of a size, one for each number of threads.
bool qcScaling_MeasureMesh(const qcScalingOptions* options, uint32_t size, qcScalingMeshRow* rows, qcMessage* message);

//  ---- boxes ---------------------------------------------------------------------------------------

/// Moving boxes: a size and the share that moves.
typedef struct qcScalingBoxRow
{
    uint32_t boxes, percent, moving;
    uint32_t steps;   ///< timed steps
    double ms, minMs; ///< moves in, pairs out: median and minimum
    double addMs;     ///< time to add all boxes and to find the pairs among them
    double bytes;     ///< memory of the library, per box
    uint64_t pairs;   ///< of boxes that moved, in the last step
} qcScalingBoxRow;

uint32_t qcScaling_CountBoxSizes(const qcScalingOptions* options);
/// Fills the rows of a size, one for each fraction.
bool qcScaling_MeasureBoxes(uint32_t size, qcScalingBoxRow rows[qc_scalingFractions], qcMessage* message);

//  ---- reports -------------------------------------------------------------------------------------

typedef struct qcScalingTable
{
    qcScalingMeshRow meshes[qc_scalingMeshSizes * qc_maxScalingThreads];
    uint32_t meshCount;
    qcScalingBoxRow boxes[qc_scalingBoxSizes * qc_scalingFractions];
    uint32_t boxCount;
} qcScalingTable;

/// The exponent e for which time grows as triangles^e, from 20 K to 1 M triangles: a straight line through the
/// logarithms. 0 where fewer than two sizes lie there.
double qcScaling_FindExponent(const qcScalingTable* table, uint32_t threads);

void qcScaling_PrintTable(const qcScalingOptions* options, const qcScalingTable* table);
/// Writes scaling_meshes.csv and scaling_boxes.csv.
bool qcScaling_WriteCsv(const qcScalingOptions* options, const qcScalingTable* table, qcMessage* message);
/// Writes the gnuplot script beside them and runs it.
bool qcScaling_Plot(const qcScalingOptions* options, const qcScalingTable* table, qcMessage* message);

#endif
