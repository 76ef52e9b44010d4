// Types and functions of qc-pairs: the options, and one run with its results.
#ifndef QC_DEMOS_PAIRS_PAIRS_H
#define QC_DEMOS_PAIRS_PAIRS_H

#include "common/exit_status.h"
#include "common/mesh_io/mesh_file.h"

#include <quickcullide/quickcullide.h>

typedef struct qcPairsOptions
{
    qcDetectDef detect;
    qcDeviceKind device;
    const char* deviceName; ///< on the command line, or null
    bool selfCollision;
    bool f64;
    uint32_t reps;
    bool json;
    const char* out;     ///< the file of the pairs, or null
    bool pairsOnOutput;  ///< the pairs go to standard output, the report to standard error
    const char* picture; ///< or null
    char** paths;
    uint32_t pathCount;
} qcPairsOptions;

/// Milliseconds of one stage over the repetitions.
typedef struct qcPairsStage
{
    const char* name;
    double min, median;
} qcPairsStage;

enum
{
    qc_stageCount = 8
};

typedef struct qcPairsRun
{
    const qcPairsOptions* options;
    qcMesh* meshes; ///< options->pathCount
    /// `device` runs the queries; null: none is needed. `pictureDevice` is the same device if that can draw.
    qcDevice* device;
    qcDevice* pictureDevice;
    qcDeviceInfo deviceInfo;
    qcScene* scene;
    const qcResult* result; ///< of the last repetition
    qcPairsStage stages[qc_stageCount];
    uint64_t relations[4]; ///< pairs of each qcRelation
} qcPairsRun;

/// Reads the command line; ends the program after --help and on a mistake.
void qcPairs_ReadOptions(int argumentCount, char** arguments, qcPairsOptions* options);

/// Writes the pairs to options->out or to standard output, one a line.
bool qcPairs_WritePairs(const qcPairsRun* run, qcMessage* message);
/// Prints the readable report, or the JSON object: on standard output, or on standard error if the pairs are there.
bool qcPairs_WriteReport(const qcPairsRun* run, qcMessage* message);
/// Draws the meshes with the PCS in red into options->picture.
qcExitStatus qcPairs_DrawPicture(const qcPairsRun* run, qcMessage* message);

#endif
