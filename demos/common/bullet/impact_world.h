// A world in which bodies break in the midst of a step, between collision detection, which finds the impacts, and the
// solver. A second detection finds the contacts of the pieces, so that these, not the whole body, are stopped.
#ifndef QC_DEMOS_COMMON_BULLET_IMPACT_WORLD_H
#define QC_DEMOS_COMMON_BULLET_IMPACT_WORLD_H

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <utility>

class qcImpactWorld : public btDiscreteDynamicsWorld
{
  public:
    /// `detected` is called after each detection, `breaksBodies` after the first one of a step. The latter breaks the
    /// bodies that are hit hard enough. True: there were any, and the pieces are in the world.
    qcImpactWorld(std::function<void()> detected, std::function<bool()> breaksBodies, btDispatcher* dispatcher,
                  btBroadphaseInterface* broadphase, btConstraintSolver* solver,
                  btCollisionConfiguration* configuration)
        : btDiscreteDynamicsWorld(dispatcher, broadphase, solver, configuration), m_detected(std::move(detected)),
          m_breaksBodies(std::move(breaksBodies))
    {
    }

    void performDiscreteCollisionDetection() override
    {
        btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
        m_detected();
        if (!m_breaksBodies())
            return;
        btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
        m_detected();
    }

  private:
    std::function<void()> m_detected;
    std::function<bool()> m_breaksBodies;
};

#endif
