// Types and functions of `qc-bench paper`: the recorded scenes of the paper's section 5, replayed for each method.
// Govindaraju, Lin, Manocha: Quick-CULLIDE, VR 2005.
#ifndef QC_DEMOS_BENCH_PAPER_PAPER_H
#define QC_DEMOS_BENCH_PAPER_PAPER_H

#include "bench/bench.h"
#include "bench/paper/replay.h"

#include <stdio.h>

enum
{
    qc_paperSceneCount = 4,
    qc_paperPartCount = qc_paperSceneCount + 1, ///< the scenes, and the factors
    qc_maxPaperRounds = 9,
    qc_paperBuildingFrames = 2, ///< first frames, in which methods build data: not part of a mean time
    qc_maxPaperFactorRows = 64
};

/// A scene of the paper, and its values in tables 1 and 2 (0: not in the paper).
typedef struct qcPaperScene
{
    const char* name; ///< for --parts
    const char* file; ///< in the folder of recordings
    const char* title;
    const char* demo;       ///< command that makes the recording
    const char* recordedTo; ///< the name that its --record is given: it may write the file beside one of that name
    double quickPcs, cullidePcs, quickMs, cullideMs;
    uint32_t frames; ///< frames of the sampled methods by default: they take seconds without a GPU
} qcPaperScene;

extern const qcPaperScene qcPaperScenes[qc_paperSceneCount];

typedef enum qcPaperMethod
{
    qc_paperCullide,
    qc_paperQuick,
    qc_paperQuickSorted,     ///< back to front
    qc_paperQuickSortedBack, ///< and second pass from the back
    qc_paperSweep,
    qc_paperLayers,
    qc_paperAuto,
    qc_paperEmbree,
    qc_paperMethodCount
} qcPaperMethod;

typedef struct qcPaperMethodInfo
{
    const char* label;
    const char* column; ///< in the CSV and in plots
    qcMethod method;
    bool backToFront, secondPassFromBack;
    bool isSampled; ///< misses pairs between samples
} qcPaperMethodInfo;

extern const qcPaperMethodInfo qcPaperMethods[qc_paperMethodCount];

typedef struct qcPaperOptions
{
    bool parts[qc_paperPartCount];
    uint32_t frames; ///< of the sampled methods; 0: each scene's own number
    bool allFrames;
    uint32_t rounds; ///< of the methods that never miss
    uint32_t resolution;
    uint32_t iterations; ///< rounds of cullide and quick over the views
    uint32_t threads;
    qcDeviceKind device;
    const char* recordings;
    const char* out;
} qcPaperOptions;

/// Reads the command line; ends the program after --help and on a mistake.
void qcPaper_ReadOptions(int argumentCount, char** arguments, qcPaperOptions* options);

//  ---- tables 1 and 2 ------------------------------------------------------------------------------

/// One method in one frame.
typedef struct qcPaperCell
{
    bool ran;
    uint32_t pcs;
    uint64_t found, missed;
    double times[qc_maxPaperRounds]; ///< positions in, pairs out
    uint32_t timeCount;
    double ms; ///< median of the times
} qcPaperCell;

/// What was measured on one scene.
typedef struct qcPaperTable
{
    const qcPaperScene* scene;
    qcPaperRecordingInfo info;
    uint32_t resolution, iterations;
    bool* isChosen; ///< frames of the sampled methods
    uint32_t chosenCount;
    uint64_t *exact, *hashes; ///< of each frame: number and hash of the pairs of `sweep`
    qcPaperCell* cells[qc_paperMethodCount];
    char embree[64]; ///< name and version; empty: not built with it
} qcPaperTable;

/// Means and sums of one method.
typedef struct qcPaperSummary
{
    uint32_t frames;
    double pcs, ms;
    uint64_t exact, missed;
} qcPaperSummary;

/// Over the frames in which it ran but the first ones; `chosenOnly`: over those of the sampled methods.
qcPaperSummary qcPaperTable_Summarize(const qcPaperTable* table, qcPaperMethod method, bool chosenOnly);

/// Fills a table; free it in any case. False with a message: a method failed, or one that never misses has missed.
bool qcPaper_Measure(const qcPaperOptions* options, const qcPaperScene* scene, const char* path,
                     const qcPaperRecordingInfo* info, qcDevice* device, qcPaperTable* table, qcMessage* message);
/// Embree's turn, in qcPaper_Measure.
bool qcPaper_MeasureEmbree(const qcPaperOptions* options, const char* path, uint32_t round, qcPaperTable* table,
                           qcMessage* message);
void qcPaperTable_Free(qcPaperTable* table);

//  ---- factors of section 5.1.3 --------------------------------------------------------------------

typedef struct qcPaperFactorRow
{
    const char* factor; ///< "views", "order", "depth" or "resolution"
    char setting[64];   ///< "xz"
    double value;       ///< along the axis of a plot
    qcPaperMethod method;
    uint32_t triangles;
    double depth; ///< mean number of triangles over a covered point of the first view
    uint32_t pcs;
    double ms;
    uint64_t exact, missed;
} qcPaperFactorRow;

typedef struct qcPaperFactors
{
    const qcPaperScene* scene;
    uint32_t frame; ///< of the recording
    uint32_t resolution;
    qcPaperFactorRow rows[qc_maxPaperFactorRows];
    uint32_t rowCount;
} qcPaperFactors;

/// Varies each factor on one frame of a recording.
bool qcPaper_MeasureFactors(const qcPaperOptions* options, const qcPaperScene* scene, const char* path,
                            const qcPaperRecordingInfo* info, qcDevice* device, qcPaperFactors* factors,
                            qcMessage* message);

//  ---- reports -------------------------------------------------------------------------------------

void qcPaper_PrintTables(const qcPaperTable* tables, uint32_t tableCount);
void qcPaper_PrintFactors(const qcPaperFactors* factors);
/// Writes paper.csv, a row for each scene, frame and method, and paper_factors.csv.
bool qcPaper_WriteCsv(const qcPaperOptions* options, const qcPaperTable* tables, uint32_t tableCount,
                      qcMessage* message);
bool qcPaper_WriteFactorsCsv(const qcPaperOptions* options, const qcPaperFactors* factors, qcMessage* message);
/// Writes the gnuplot script beside the CSVs and runs it.
bool qcPaper_Plot(const qcPaperOptions* options, const qcPaperTable* tables, uint32_t tableCount,
                  const qcPaperFactors* factors, qcMessage* message);

#endif
