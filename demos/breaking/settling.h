// Pieces that have come to rest stand still until something moves near them. Bullet puts whole islands of touching
// bodies to sleep only, and in a pile of rubble one piece always trembles.
#ifndef QC_DEMOS_BREAKING_SETTLING_H
#define QC_DEMOS_BREAKING_SETTLING_H

#include <btBulletDynamicsCommon.h>

#include <vector>

/// Makes a body of a world static where it is. Taken out of the world and added again, it would be new to collision
/// detection, which costs a long step.
void qcFreezeBody(btRigidBody* body);
/// Makes it move again.
void qcThawBody(btRigidBody* body, btScalar mass, const btVector3& inertia, const btVector3& gravity);

class qcSettling
{
  public:
    /// The world must outlive this object, and the bodies too.
    explicit qcSettling(btDiscreteDynamicsWorld* world) : m_world(world)
    {
    }

    /// A body that moves from now on, and may come to rest.
    void Add(btRigidBody* body, btScalar mass, const btVector3& inertia);
    /// Bodies in this box may have lost what they stood on.
    void WakeIn(const btVector3& lower, const btVector3& upper);
    /// Call it before each step: wakes what something fast is near, and what stood on something that has left.
    void Wake();
    /// Call it after each step of `seconds`: what has been slow for a while, on something that stands, stands, too.
    void Settle(btScalar seconds);
    /// Number of bodies at rest.
    size_t RestingCount() const;

  private:
    struct Entry
    {
        btRigidBody* body;
        btScalar mass;
        btVector3 inertia;
        btScalar slowSeconds = 0;
        bool isResting = false;
        bool hasLeft = true;                      ///< where it last rested
        btVector3 place{0, 0, 0};                 ///< of the last rest
        btVector3 lower{0, 0, 0}, upper{0, 0, 0}; ///< its box there
    };

    void Rest(Entry* entry);
    std::vector<const btCollisionObject*> FindSupported() const;

    btDiscreteDynamicsWorld* m_world;
    std::vector<Entry> m_entries;
};

#endif
