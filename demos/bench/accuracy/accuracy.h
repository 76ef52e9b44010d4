// Types and functions of `qc-bench accuracy`: the options, the settings tried on a scene, a row for each.
#ifndef QC_DEMOS_BENCH_ACCURACY_ACCURACY_H
#define QC_DEMOS_BENCH_ACCURACY_ACCURACY_H

#include "bench/scenes/scenes.h"
#include "bench/bench.h"

#include <quickcullide/quickcullide.h>

#include <stdio.h>

enum
{
    qc_methodCount = qc_methodLayers + 1,
    qc_maxResolutions = 13, // powers of two up to 4096
    qc_maxViews = 15,       // ordered choices of 1 to 3 of three axes
    qc_switchCount = 8,     // what goes beyond the paper, on and off
    qc_maxRuns = 15,
    // Over the images: `layers` and `cullide` once, `quick` with all its switches; each method once without an image.
    qc_maxSettings = qc_maxResolutions * qc_maxViews * (2 + qc_switchCount) + qc_methodCount
};

typedef struct qcAccuracyOptions
{
    bool scenes[qc_benchSceneCount];
    bool methods[qc_methodCount];
    uint32_t resolutions[qc_maxResolutions], layerResolutions[qc_maxResolutions];
    uint32_t resolutionCount, layerResolutionCount;
    char views[qc_maxViews][4];
    uint32_t viewCount;
    bool thin;     ///< fewer settings on all scenes but the first
    bool full;     ///< all switches of quick; brute force on large scenes too
    uint32_t runs; ///< max runs of a fast setting
    uint32_t rounds;
    uint32_t threads;
    double margin; ///< as a share of the scene's extent
    bool touching;
    qcDeviceKind device;
    qcBenchModels models;
    const char* out;
} qcAccuracyOptions;

/// Reads the command line; ends the program after --help and on a mistake.
void qcAccuracy_ReadOptions(int argumentCount, char** arguments, qcAccuracyOptions* options);

//  ---- settings ------------------------------------------------------------------------------------

/// The settings of one query. Settings that a method does not have are zero.
typedef struct qcAccuracySetting
{
    qcMethod method;
    uint32_t resolution; ///< pixels on a side; 0: the planner's choice
    char views[4];       ///< empty: the planner's choice
    bool backToFront, secondPassFromBack, reliable;
} qcAccuracySetting;

/// Lists the settings for a scene by its number of triangles; at most qc_maxSettings.
uint32_t qcAccuracy_ListSettings(const qcAccuracyOptions* options, int scene, uint32_t triangleCount,
                                 qcAccuracySetting* settings);

/// The method for the reference: brute force where it takes seconds, otherwise the sweep, which the tests compare with
/// brute force.
qcMethod qcAccuracy_ChooseReference(const qcAccuracyOptions* options, uint32_t triangleCount);

/// Settings that differ only in their image: a line of the report and of the plot's legend.
typedef struct qcAccuracySeries
{
    qcAccuracySetting setting; ///< without image
    const char* title;
    unsigned color; ///< red, green, blue: a byte each
} qcAccuracySeries;

enum
{
    qc_accuracySeriesCount = 12
};

/// All series but that of `auto`.
extern const qcAccuracySeries qcAccuracySeries_all[qc_accuracySeriesCount];

bool qcAccuracy_IsOf(const qcAccuracySeries* series, const qcAccuracySetting* setting);

/// True for `cullide` and `quick`, which sample at pixels.
bool qcAccuracy_IsSampled(qcMethod method);

//  ---- rows ----------------------------------------------------------------------------------------

typedef struct qcAccuracyRow
{
    qcAccuracySetting setting;
    char skipped[256]; ///< reason why it did not run; empty: it ran
    char note[256];    ///< reason why another method ran for `auto`; or empty
    qcMethod ran;
    uint32_t image;   ///< pixels on a side or columns that were used; 0: none
    uint32_t runs;    ///< timed runs
    double ms, minMs; ///< new vertices in, pairs out: median and minimum of the runs
    uint64_t queries; ///< visibility queries; 0: the image was not used
    uint64_t pcs, candidates, found, missed, extra;
} qcAccuracyRow;

/// One scene and what was measured on it.
typedef struct qcAccuracyTable
{
    int scene; ///< index of the scene
    uint32_t bodyCount, triangleCount;
    double margin; ///< scene units
    qcMethod reference;
    uint64_t exact; ///< pairs of the reference
    uint32_t threads;
    char device[16];
    qcAccuracyRow* rows;
    uint32_t rowCount;
} qcAccuracyTable;

/// Share of the reference's pairs that the row lacks; 0 where there are none.
double qcAccuracy_MissedShare(const qcAccuracyTable* table, const qcAccuracyRow* row);

/// Fills the table: the reference, then a row for each setting. False with a message: the reference or a method that
/// needs no device failed.
bool qcAccuracy_Measure(const qcAccuracyOptions* options, const qcBenchScene* scene, qcDevice* device,
                        qcAccuracyTable* table, qcMessage* message);

/// Runs each method that needs GL on a small scene, so that no measurement includes the first use of the device.
void qcAccuracy_WarmUp(const qcAccuracyOptions* options, qcDevice* device);

//  ---- reports -------------------------------------------------------------------------------------

/// Prints a readable summary of one scene on standard output.
void qcAccuracy_PrintTable(const qcAccuracyTable* table);

/// Writes all rows as CSV.
bool qcAccuracy_WriteCsv(const qcAccuracyOptions* options, const qcAccuracyTable* tables, uint32_t tableCount,
                         qcMessage* message);

/// Writes the gnuplot script beside the CSV and runs it; without gnuplot a message on standard error.
bool qcAccuracy_Plot(const qcAccuracyOptions* options, const qcAccuracyTable* tables, uint32_t tableCount,
                     qcMessage* message);

#endif
