// The scenes of `qc-bench through`, in which bodies are thrown, dropped, wrung and crushed.
#ifndef QC_DEMOS_BENCH_THROUGH_SCENES_H
#define QC_DEMOS_BENCH_THROUGH_SCENES_H

#include "bench/through/world.h"

/// What a scene keeps, and so is measured.
enum qcThroughKeeps
{
    qc_keepsNothing, ///< a kinematic body or pinned nodes do work
    qc_keepsEnergy,
    qc_keepsMomentum ///< and energy
};

struct qcThroughScene
{
    const char* name;  ///< "throw-20", for the command line
    const char* title; ///< "cloth thrown at cloth, 20 m/s"
    bool isSoft;       ///< in both worlds of soft bodies; otherwise rigid meshes alone
    bool isFast;       ///< at 240 Hz too
    bool crushes;      ///< a kinematic mesh leaves no room: pairs that the library reports are no failure
    qcThroughKeeps keeps;
    double seconds; ///< simulated
    btScalar gravity;
    btScalar speed; ///< m/s
    void (*build)(qcThroughWorld* world, qcJitter* jitter, btScalar speed);
    /// Moves kinematic bodies and pinned nodes to their places at the end of the next step; or null. `time`: seconds
    /// since the start.
    void (*drive)(qcThroughWorld* world, double time, btScalar speed);
};

const std::vector<qcThroughScene>& qcThroughScenes();
/// Not in that list.
const qcThroughScene& qcThroughFilmScene();
/// Null: there is none of that name.
const qcThroughScene* qcFindThroughScene(const char* name);

#endif
