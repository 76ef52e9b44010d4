// Takes a body up and drops it, again and again, each time over another place.
#ifndef QC_DEMOS_BREAKING_CRANE_H
#define QC_DEMOS_BREAKING_CRANE_H

#include <btBulletDynamicsCommon.h>

#include <functional>

class qcCrane
{
  public:
    /// `targets`: in the order of the drops, which begin anew after the last one. `mass` and `inertia`: of the body
    /// when it falls. `upright`: orientation in which it is carried.
    qcCrane(btRigidBody* body, btScalar mass, const btVector3& inertia, const btQuaternion& upright,
            std::function<btVector3()> findTarget);

    /// Call it before each step of `seconds`.
    void Update(btScalar seconds);
    /// The body has hit something hard. After a while the crane takes it up.
    void NoteImpact();

    size_t Drops() const
    {
        return m_drops;
    }
    bool IsCarrying() const
    {
        return m_carries;
    }

  private:
    btVector3 ReleasePlace() const;
    btQuaternion ReleaseOrientation() const;
    void Grab();
    void Drop();
    void StopBody();
    void Carry(btScalar seconds);

    btRigidBody* m_body;
    btScalar m_mass;
    btVector3 m_inertia;
    btQuaternion m_upright;
    std::function<btVector3()> m_findTarget;
    btVector3 m_target;
    size_t m_drops = 0;
    bool m_carries = true;
    bool m_hasHit = false;
    btScalar m_clock = 0; ///< seconds since the drop or, once it has hit, since the impact
    btVector3 m_from{0, 0, 0};
    btQuaternion m_fromOrientation = btQuaternion::getIdentity();
    btScalar m_carried = 0; ///< seconds
};

#endif
