// Ablation of manifolds: scenes are run with all stages, then with each stage switched off.
#ifndef QC_DEMOS_BENCH_ABLATION_ABLATION_H
#define QC_DEMOS_BENCH_ABLATION_ABLATION_H

#include <functional>

/// Means over the runs of a scene; negative: not measured in this scene.
struct qcAblationResult
{
    double ms = 0;          ///< of the manifold stages, per detection
    double points = 0;      ///< per detection
    double depth = -1;      ///< still scenes: depth of the deepest point relative to the true depth; 1 is exact
    double penetration = 0; ///< moving scenes: the deepest overlap at the end, measured with all stages; mm
    double speed = -1;      ///< moving scenes: median speed of the bodies in the last second; mm/s
};

struct qcAblationScene
{
    const char* name;
    unsigned runs; ///< seeds 1, 2, ...
    /// One run with a stage switched off ("": none). Exits with a message if a detection fails.
    std::function<qcAblationResult(unsigned seed, const char* stage)> run;
};

/// Switches a stage off for the detections that follow; "" switches all on.
void qcSwitchOff(const char* stage);

/// Scenes of known depth: a box sunk into tiles; displaced cells of a cube.
qcAblationResult qcRunSunkBox(unsigned seed, const char* stage);
qcAblationResult qcRunDisplacedCells(unsigned seed, const char* stage);

/// Simulations: piles of boxes and of tori in a bin; a cube that falls apart.
qcAblationResult qcRunBoxPile(unsigned seed, const char* stage, unsigned steps);
qcAblationResult qcRunTorusPile(unsigned seed, const char* stage, unsigned steps);
qcAblationResult qcRunFracture(unsigned seed, const char* stage, unsigned steps);

#endif
