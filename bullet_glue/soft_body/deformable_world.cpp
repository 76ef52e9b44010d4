// The deformable world: Bullet's step with contact of ours in the place of its own.
//
// Bullet 3.24 has constraints between faces and nodes (btDeformableFaceNodeContactConstraint), but never makes one:
// btDeformableContactProjection::setConstraints does not read m_faceNodeContacts. It answers these with impulses of
// applyRepulsionForce, after the implicit solve, in an order drawn from a random seed that all worlds of a process
// share. So contact is a matter of positions here, as in the classic world.
#include "quickcullide/bullet_deformable.h"

#include "soft_body/contact_step.h"

namespace
{
/// Nodes that contacts moved go to their places; velocities, and what else Bullet keeps of positions, follow.
void MoveNodes(const qcSceneSoftBody& known, btScalar timeStep)
{
    bool moved = false;
    known.ForEachMoved(
        [&](int i)
        {
            btSoftBody::Node& node = known.body->m_nodes[i];
            node.m_v += known.MotionOf(size_t(i), node.m_x) / timeStep;
            node.m_vn = node.m_v;
            node.m_q = node.m_x = known.places[size_t(i)];
            moved = true;
        });
    if (moved)
        known.body->interpolateRenderMesh();
}
} // namespace

qcDeformableWorld::qcDeformableWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase,
                                     btDeformableMultiBodyConstraintSolver* constraintSolver,
                                     btCollisionConfiguration* collisionConfiguration,
                                     btDeformableBodySolver* deformableSolver, qcDevice* device)
    : btDeformableMultiBodyDynamicsWorld(dispatcher, broadphase, constraintSolver, collisionConfiguration,
                                         deformableSolver),
      qcSoftBodyContact(device)
{
}

qcDeformableWorld::~qcDeformableWorld() = default;

/// As the base class has it, but for performDeformableCollisionDetection, applyRepulsionForce and
/// performGeometricCollisions after the callbacks.
void qcDeformableWorld::internalSingleStepSimulation(btScalar timeStep)
{
    if (m_internalPreTickCallback != nullptr)
        m_internalPreTickCallback(this, timeStep);
    m_implementation->Begin(getSoftBodyArray());
    reinitialize(timeStep);
    applyRigidBodyGravity(timeStep);
    predictUnconstraintMotion(timeStep);
    performDiscreteCollisionDetection();
    calculateSimulationIslands();
    beforeSolverCallbacks(timeStep);
    solveConstraints(timeStep);
    afterSolverCallbacks(timeStep);
    integrateTransforms(timeStep);
    updateActions(timeStep);
    updateActivationState(timeStep);
    m_implementation->Tell();
}

void qcDeformableWorld::integrateTransforms(btScalar timeStep)
{
    Implementation& my = *m_implementation;
    my.Start(getSoftBodyArray(), &btSoftBody::Node::m_x);
    btDeformableMultiBodyDynamicsWorld::integrateTransforms(timeStep);
    if (!my.Resolve(timeStep))
        return;
    for (const qcSceneSoftBody& known : my.scene.Bodies())
        MoveNodes(known, timeStep);
}
