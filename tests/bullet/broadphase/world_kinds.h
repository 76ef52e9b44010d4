// Each kind of Bullet world, with its parts, on any broadphase.
#ifndef QC_TESTS_BULLET_BROADPHASE_WORLD_KINDS_H
#define QC_TESTS_BULLET_BROADPHASE_WORLD_KINDS_H

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletSoftBody/btSoftBody.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

enum class qcWorldKind
{
    collision,  ///< btCollisionWorld
    discrete,   ///< btDiscreteDynamicsWorld
    discreteMt, ///< btDiscreteDynamicsWorldMt, on a task scheduler
    multiBody,  ///< btMultiBodyDynamicsWorld
    softRigid,  ///< btSoftRigidDynamicsWorld
    deformable, ///< btDeformableMultiBodyDynamicsWorld
};
constexpr int qc_worldKindCount = 6;
extern const char* const qcWorldKindNames[qc_worldKindCount];

class qcWorld
{
  public:
    /// Takes ownership of the broadphase.
    qcWorld(qcWorldKind kind, btBroadphaseInterface* broadphase);
    ~qcWorld();
    qcWorld(const qcWorld&) = delete;
    qcWorld& operator=(const qcWorld&) = delete;

    template <class Shape, class... Arguments> Shape* Make(Arguments... arguments)
    {
        shapes.push_back(std::make_unique<Shape>(arguments...));
        return static_cast<Shape*>(shapes.back().get());
    }

    /// A rigid body; mass 0: static.
    btRigidBody* AddBody(btScalar mass, const btTransform& place, btCollisionShape* shape, int group, int mask);
    btRigidBody* AddBody(btScalar mass, const btVector3& place, btCollisionShape* shape);
    /// Takes ownership of the object.
    void AddObject(std::unique_ptr<btCollisionObject> object, int group, int mask);
    /// A piece of cloth; null if this kind of world has none.
    btSoftBody* AddCloth(const btVector3& centre);
    /// Removes and destroys it.
    void Remove(btCollisionObject* object);
    /// One sixtieth of a second. A btCollisionWorld moves bodies by their velocities alone.
    void Step();

    std::unique_ptr<btBroadphaseInterface> broadphase;
    std::unique_ptr<btCollisionConfiguration> configuration;
    std::unique_ptr<btCollisionDispatcher> dispatcher;
    btGhostPairCallback ghostPairs;
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::unique_ptr<btCollisionWorld> world;
    btDiscreteDynamicsWorld* dynamics = nullptr; ///< the same world, or null
    std::vector<std::unique_ptr<btCollisionObject>> objects;

  private:
    std::vector<std::unique_ptr<btConstraintSolver>> m_solvers;
    std::unique_ptr<class btSoftBodySolver> m_softSolver;
};

#endif
