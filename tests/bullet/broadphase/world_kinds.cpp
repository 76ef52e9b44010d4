// Each kind of world that Bullet has, as an application makes it.
#include "bullet/broadphase/world_kinds.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolverMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btDefaultSoftBodySolver.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <LinearMath/btThreads.h>

#include <algorithm>

const char* const qcWorldKindNames[qc_worldKindCount] = {
    "btCollisionWorld",         "btDiscreteDynamicsWorld",  "btDiscreteDynamicsWorldMt",
    "btMultiBodyDynamicsWorld", "btSoftRigidDynamicsWorld", "btDeformableMultiBodyDynamicsWorld"};

namespace
{
/// A Bullet without threads has only the sequential scheduler.
btITaskScheduler* TaskScheduler()
{
    static btITaskScheduler* s_scheduler = btCreateDefaultTaskScheduler();
    return s_scheduler != nullptr ? s_scheduler : btGetSequentialTaskScheduler();
}

template <class Base, class Made> Made* Keep(std::unique_ptr<Base>& place, Made* made)
{
    place.reset(made);
    return made;
}
} // namespace

qcWorld::qcWorld(qcWorldKind kind, btBroadphaseInterface* made)
    : broadphase(made), configuration(new btSoftBodyRigidBodyCollisionConfiguration)
{
    if (kind == qcWorldKind::discreteMt)
    {
        btSetTaskScheduler(TaskScheduler());
        dispatcher = std::make_unique<btCollisionDispatcherMt>(configuration.get(), 10);
    }
    else
        dispatcher = std::make_unique<btCollisionDispatcher>(configuration.get());
    m_solvers.resize(2);
    switch (kind)
    {
        case qcWorldKind::collision:
            world = std::make_unique<btCollisionWorld>(dispatcher.get(), made, configuration.get());
            break;
        case qcWorldKind::discrete:
            dynamics =
                Keep(world, new btDiscreteDynamicsWorld(dispatcher.get(), made,
                                                        Keep(m_solvers[0], new btSequentialImpulseConstraintSolver),
                                                        configuration.get()));
            break;
        case qcWorldKind::discreteMt:
            dynamics =
                Keep(world, new btDiscreteDynamicsWorldMt(
                                dispatcher.get(), made,
                                Keep(m_solvers[0], new btConstraintSolverPoolMt(TaskScheduler()->getMaxNumThreads())),
                                Keep(m_solvers[1], new btSequentialImpulseConstraintSolverMt), configuration.get()));
            break;
        case qcWorldKind::multiBody:
            dynamics = Keep(world, new btMultiBodyDynamicsWorld(dispatcher.get(), made,
                                                                Keep(m_solvers[0], new btMultiBodyConstraintSolver),
                                                                configuration.get()));
            break;
        case qcWorldKind::softRigid:
            dynamics =
                Keep(world, new btSoftRigidDynamicsWorld(
                                dispatcher.get(), made, Keep(m_solvers[0], new btSequentialImpulseConstraintSolver),
                                configuration.get(), Keep(m_softSolver, new btDefaultSoftBodySolver)));
            break;
        case qcWorldKind::deformable:
        {
            auto* solver = Keep(m_solvers[0], new btDeformableMultiBodyConstraintSolver);
            auto* softSolver = Keep(m_softSolver, new btDeformableBodySolver);
            solver->setDeformableSolver(softSolver);
            dynamics = Keep(world, new btDeformableMultiBodyDynamicsWorld(dispatcher.get(), made, solver,
                                                                          configuration.get(), softSolver));
            break;
        }
    }
    world->getPairCache()->setInternalGhostPairCallback(&ghostPairs);
    // So that the solver's contacts have the same order in all runs.
    world->getDispatchInfo().m_deterministicOverlappingPairs = true;
    if (dynamics != nullptr)
        dynamics->setGravity(btVector3(0, -10, 0));
}

qcWorld::~qcWorld()
{
    while (!objects.empty())
        Remove(objects.back().get());
    world.reset();
}

btRigidBody* qcWorld::AddBody(btScalar mass, const btTransform& place, btCollisionShape* shape, int group, int mask)
{
    btVector3 inertia(0, 0, 0);
    if (mass > 0)
        shape->calculateLocalInertia(mass, inertia);
    auto body = std::make_unique<btRigidBody>(mass, nullptr, shape, inertia);
    body->setWorldTransform(place);
    body->setInterpolationWorldTransform(place);
    btRigidBody* added = body.get();
    if (dynamics != nullptr)
        dynamics->addRigidBody(added, group, mask);
    else
        world->addCollisionObject(added, group, mask);
    objects.push_back(std::move(body));
    return added;
}

btRigidBody* qcWorld::AddBody(btScalar mass, const btVector3& place, btCollisionShape* shape)
{
    const bool fixed = mass == 0;
    return AddBody(mass, btTransform(btQuaternion::getIdentity(), place), shape,
                   fixed ? btBroadphaseProxy::StaticFilter : btBroadphaseProxy::DefaultFilter,
                   fixed ? btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter
                         : btBroadphaseProxy::AllFilter);
}

void qcWorld::AddObject(std::unique_ptr<btCollisionObject> object, int group, int mask)
{
    world->addCollisionObject(object.get(), group, mask);
    objects.push_back(std::move(object));
}

btSoftBody* qcWorld::AddCloth(const btVector3& centre)
{
    auto* classic = dynamic_cast<btSoftRigidDynamicsWorld*>(dynamics);
    auto* deformable = dynamic_cast<btDeformableMultiBodyDynamicsWorld*>(dynamics);
    if (classic == nullptr && deformable == nullptr)
        return nullptr;
    btSoftBodyWorldInfo& info = classic != nullptr ? classic->getWorldInfo() : deformable->getWorldInfo();
    info.m_gravity.setValue(0, -10, 0);
    auto corner = [&](int x, int z) { return centre + btVector3(btScalar(x), 0, btScalar(z)); };
    std::unique_ptr<btSoftBody> cloth(btSoftBodyHelpers::CreatePatch(info, corner(-1, -1), corner(1, -1), corner(-1, 1),
                                                                     corner(1, 1), 9, 9, 0, true));
    cloth->setTotalMass(1);
    btSoftBody* added = cloth.get();
    objects.push_back(std::move(cloth));
    if (classic != nullptr)
        classic->addSoftBody(added);
    else
    {
        added->m_cfg.collisions = btSoftBody::fCollision::SDF_RD;
        deformable->addSoftBody(added);
    }
    return added;
}

void qcWorld::Remove(btCollisionObject* object)
{
    world->removeCollisionObject(object);
    objects.erase(std::find_if(objects.begin(), objects.end(), [&](const auto& o) { return o.get() == object; }));
}

void qcWorld::Step()
{
    const btScalar step = btScalar(1) / 60;
    if (dynamics != nullptr)
    {
        dynamics->stepSimulation(step, 0);
        return;
    }
    for (const auto& object : objects)
        if (btRigidBody* body = btRigidBody::upcast(object.get()))
        {
            btTransform next;
            body->predictIntegratedTransform(step, next);
            if (!body->isStaticOrKinematicObject() && body->isActive())
                body->setWorldTransform(next);
        }
    world->performDiscreteCollisionDetection();
}
