// The scenes of `qc-bench stability`.
#ifndef QC_DEMOS_BENCH_STABILITY_SCENES_H
#define QC_DEMOS_BENCH_STABILITY_SCENES_H

#include "quickcullide/bullet_soft_body.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <memory>
#include <string>
#include <vector>

class qcStabilityScene
{
  public:
    virtual ~qcStabilityScene() = default;
    /// False with a message.
    virtual bool Step(std::string* message) = 0;
    virtual btDiscreteDynamicsWorld& World() = 0;
    /// Null: no soft bodies.
    virtual const qcSoftBodyStatistics* SoftStatistics() const
    {
        return nullptr;
    }
};

struct qcStabilitySceneDef
{
    const char* name;
    const char* title;
    /// Size by default and with --full.
    const char *size, *fullSize;
    double stepSeconds;
    /// Seconds after which the scene has come to rest: from here on its energy must not grow, which
    /// shorter runs don't show.
    double settledSeconds;
    std::unique_ptr<qcStabilityScene> (*make)(bool full);
    /// What adds energy to the scene as long as it runs, so that its growth is no failure; null: nothing.
    const char* driven = nullptr;
    bool selfCollision = true; ///< of its soft bodies
    /// How far --jitter moves and turns bodies at the start, m and radians: see jitter.h.
    double shift = 0.02, turn = 0.1;
};

const std::vector<qcStabilitySceneDef>& qcStabilityScenes();
/// Null: there is none of this name.
const qcStabilitySceneDef* qcFindStabilityScene(const char* name);

#endif
