// Runs of a scene of `qc-bench through`, and the row of the table that they make.
#ifndef QC_DEMOS_BENCH_THROUGH_MEASURE_H
#define QC_DEMOS_BENCH_THROUGH_MEASURE_H

#include "bench/through/scenes.h"

#include <string>
#include <vector>

/// "classic", "deformable", "implicit", "rigid".
const char* qcThroughKindName(qcThroughKind kind);

/// A row of the table: a scene in a world at a rate. Sums over all runs, but for the fields that are means or maxima.
struct qcThroughRow
{
    std::string scene, world, precision;
    int hz = 0, runs = 0;
    int failingRuns = 0; ///< with a penetrating pair, or a step whose query failed
    size_t steps = 0;
    size_t ends = 0, inside = 0, tangled = 0, uncertified = 0; ///< see qcThroughPairs
    size_t unproven = 0, exempt = 0;                           ///< as the library's statistics have them
    double planes = 0, zoneNodes = 0;                          ///< a step
    double momentum = 0; ///< at the end, along the momentum at the start, relative to it, in the worst run; NaN: none
    double energy = 0;   ///< maximum over all steps and runs, relative to the start; NaN: not kept
    double detectMs = 0, respondMs = 0, stepMs = 0; ///< milliseconds of a step

    bool IsOf(const qcThroughRow& other) const
    {
        return scene == other.scene && world == other.world && precision == other.precision && hz == other.hz;
    }
};

struct qcThroughDef
{
    const qcThroughScene* scene;
    qcThroughKind kind;
    int hz;
    int runs;
    int firstRun;    ///< number of the first run, which its displacements depend on
    bool continuous; ///< qcSoftBodySettings::continuous
    bool brute;      ///< the oracle tests every pair
    bool prints;     ///< each step, on standard error
    unsigned threads;
};

/// False: the oracle's query failed; the reason is in qcLastMessage. Ends before its time on Ctrl-C.
bool qcMeasureThrough(const qcThroughDef& def, qcThroughRow* row);

#endif
