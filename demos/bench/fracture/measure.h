// A run of the fracture demo's world, measured: time of its steps, depth by exact tests, rest.
#ifndef QC_DEMOS_BENCH_FRACTURE_MEASURE_H
#define QC_DEMOS_BENCH_FRACTURE_MEASURE_H

#include "fracture/world.h"

struct qcFractureRow
{
    bool hulls = false;
    unsigned seed = 0;
    size_t pieces = 0;
    size_t steps = 0; ///< after the break
    /// Milliseconds of the step of the break, and its parts.
    double breakMs = 0, cutMs = 0, bodiesMs = 0, detectionMs = 0, solverMs = 0;
    double firstMs = 0, laterMs = 0,
           longestMs = 0; ///< means of the 40 steps after the break and of later ones; longest
    double points = 0;    ///< in Bullet's manifolds; mean after the break
    /// The deepest point of an exact detection of the pieces' meshes, in every eighth step: maximum and mean, m.
    double deepest = 0, meanDepth = 0;
    double underFloor = 0;  ///< depth of the lowest vertex under the floor: maximum of all steps from the break on, m
    size_t penetrating = 0; ///< pairs of triangles at the end
    double energy = 0;      ///< kinetic, at the end, J
    size_t awake = 0;       ///< bodies at the end
    double restSeconds = 0; ///< from the break until the energy stays below 10 J; -1: not reached
};

/// Runs a request until `steps` steps after the break. Interrupted: the steps so far. False with a message.
bool qcMeasureFracture(const qcFractureModel& model, const qcFractureRequest& request, uint32_t steps,
                       qcFractureRow* row, std::string* message);

#endif
