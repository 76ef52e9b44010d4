// A Bullet world of a scene, with one kind of shape.
#include "bench/piles/world.h"

#include "common/stopwatch.h"

#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <algorithm>

void qcPilesBulletWorld::performDiscreteCollisionDetection()
{
    double start = qcStopwatch_NowMs();
    btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
    detectionMs += qcStopwatch_NowMs() - start;
}

void qcPilesBulletWorld::integrateTransforms(btScalar timeStep)
{
    btDiscreteDynamicsWorld::integrateTransforms(timeStep);
    m_integratedMs = qcStopwatch_NowMs();
}

void qcPilesBulletWorld::updateActivationState(btScalar timeStep)
{
    detectionMs += qcStopwatch_NowMs() - m_integratedMs;
    btDiscreteDynamicsWorld::updateActivationState(timeStep);
}

qcPilesWorld::qcPilesWorld(const qcPilesSetup& setup, qcPilesContestant contestant, unsigned threads)
{
    if (contestant == qcPilesContestant::gimpact)
        btGImpactCollisionAlgorithm::registerAlgorithm(&m_dispatcher);
    if (contestant == qcPilesContestant::ours)
        m_contact.addTo(&m_world);
    m_contact.setThreadCount(threads);
    m_ground.setFriction(btScalar(0.8));
    m_world.addRigidBody(&m_ground);
    if (setup.binHalf > 0)
        AddBin(setup.binHalf);
    std::vector<btVector3> inertias;
    for (const qcTriangles& model : setup.models)
    {
        inertias.emplace_back();
        model.MakeShape()->calculateLocalInertia(mass, inertias.back());
        m_shapes.push_back(MakeShape(model, contestant));
    }
    for (const qcPilesBody& body : setup.bodies)
    {
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, m_shapes[body.model].get(), inertias[body.model]);
        info.m_startWorldTransform = body.place;
        info.m_friction = btScalar(0.6);
        info.m_rollingFriction = btScalar(0.01);
        m_bodies.emplace_back(new btRigidBody(info));
        m_world.addRigidBody(m_bodies.back().get());
        // Bodies that rest are measured awake.
        m_bodies.back()->forceActivationState(DISABLE_DEACTIVATION);
    }
}

qcPilesWorld::~qcPilesWorld()
{
    for (const auto& body : m_bodies)
        m_world.removeRigidBody(body.get());
    if (m_bin != nullptr)
        m_world.removeRigidBody(m_bin.get());
    m_world.removeRigidBody(&m_ground);
}

std::unique_ptr<btCollisionShape> qcPilesWorld::MakeShape(const qcTriangles& model, qcPilesContestant contestant)
{
    std::unique_ptr<btCollisionShape> shape;
    if (contestant == qcPilesContestant::ours)
        shape = model.MakeShape();
    else if (contestant == qcPilesContestant::gimpact)
    {
        m_arrays.push_back(model.MakeArray());
        shape.reset(new btGImpactMeshShape(m_arrays.back().get()));
    }
    else
    {
        auto* hull =
            new btConvexHullShape(model.positions.data(), int(model.positions.size() / 3), 3 * int(sizeof(btScalar)));
        hull->optimizeConvexHull();
        shape.reset(hull);
    }
    // A qcMeshShape has this margin by default, and a smaller one if its triangles are fine.
    if (contestant != qcPilesContestant::ours)
        shape->setMargin(margin);
    if (contestant == qcPilesContestant::gimpact)
        static_cast<btGImpactMeshShape*>(shape.get())->updateBound();
    return shape;
}

void qcPilesWorld::AddBin(btScalar half)
{
    m_binTriangles = qcMakeBin(half, 3, 4);
    m_arrays.push_back(m_binTriangles.MakeArray());
    m_binShape.reset(new btBvhTriangleMeshShape(m_arrays.back().get(), true));
    m_binShape->setMargin(margin);
    m_bin.reset(new btRigidBody(0, nullptr, m_binShape.get()));
    m_world.addRigidBody(m_bin.get());
}

double qcPilesWorld::Step(double* detectionMs)
{
    m_world.detectionMs = 0;
    double start = qcStopwatch_NowMs();
    m_world.stepSimulation(stepSeconds, 0);
    double ms = qcStopwatch_NowMs() - start;
    *detectionMs = m_world.detectionMs;
    if (m_contact.getStatistics().status != qc_statusOk)
        m_status = m_contact.getStatistics().status;
    return ms;
}

void qcPilesWorld::Sleep()
{
    for (const auto& body : m_bodies)
        body->forceActivationState(ISLAND_SLEEPING);
}

qcPilesState qcPilesWorld::State() const
{
    qcPilesState state;
    // Bullet's getter is const on the array only.
    auto dispatcher = const_cast<btCollisionDispatcher*>(&m_dispatcher);
    for (int m = 0; m < dispatcher->getNumManifolds(); m++)
        state.points += dispatcher->getManifoldByIndexInternal(m)->getNumContacts();
    for (const auto& body : m_bodies)
        state.speed = std::max(state.speed, double(body->getLinearVelocity().length() +
                                                   body->getAngularVelocity().length() *
                                                       body->getCollisionShape()->getAngularMotionDisc()));
    return state;
}
