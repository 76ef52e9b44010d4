// Limits the speed at which rigid bodies rebound from soft bodies whose solver moves nodes by positions.
//
// Bullet's sweeps over links take back the stretch of a link in one step, however heavy the body that stretched it. A
// body that followed would be thrown: from a sheet of 2 kg in steps of a millisecond a ball of 20 kg rose 300 m.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_REBOUNDS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_REBOUNDS_H

#include "soft_body/response/elastic_system.h"

class qcRebounds
{
  public:
    void Begin(btScalar timeStep);
    /// Has a spring of a rigid body stop the body's own approach, and leave it no faster than by half of the energy
    /// that soft bodies have taken from it while it pressed on them. `motion`: of the rigid body's point in this step;
    /// `sprung`: of its nodes, by their links.
    void Limit(const qcSceneSoftBody& soft, const qcObjectKey& rigid, const btVector3& motion, const btVector3& sprung,
               qcElasticSpring* spring);
    /// Limits the velocities of the solution, and reads what it takes and gives.
    void End(qcElasticSystem* solution);

  private:
    struct Rebound
    {
        qcObjectKey rigid;
        int index;            ///< of the rigid body in the system
        btVector3 frame;      ///< velocity of the soft body
        btVector3 start;      ///< velocity of the rigid body in this frame at the start of the step, without its weight
        btScalar startEnergy; ///< kinetic, of the rigid body in this frame
        btScalar energy;      ///< that may be given back
        btScalar speed;       ///< that springs may give it
    };

    Rebound& Find(const qcSceneSoftBody& soft, const qcObjectKey& rigid, int index);
    btScalar ShareOf(const qcElasticSystem& system, const Rebound& rebound) const;
    btScalar GainOf(const qcElasticSystem& system, const Rebound& rebound, btScalar share) const;

    btScalar m_timeStep = 0;
    std::vector<Rebound> m_rebounds, m_previous;
};

#endif
