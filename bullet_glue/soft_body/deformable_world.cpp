// The deformable world: Bullet's step with this library's contact instead of its own.
//
// Contact works on positions, as in the classic world. Bullet 3.24 has a constraint between faces and nodes
// (btDeformableFaceNodeContactConstraint), but never creates one: btDeformableContactProjection::setConstraints does
// not read m_faceNodeContacts. Bullet answers these contacts with impulses (applyRepulsionForce) after the implicit
// solve, in an order drawn from a random seed that all worlds of a process share.
#include "quickcullide/bullet_deformable.h"

#include "soft_body/contact_step.h"
#include "soft_body/response/deformable_elasticity.h"

namespace
{
/// Writes the positions of the nodes that contacts moved, their velocities, and what Bullet derives from positions.
void MoveDeformableNodes(const qcSceneSoftBody& soft, btScalar timeStep)
{
    bool moved = false;
    soft.ForEachMoved(
        [&](int i)
        {
            btSoftBody::Node& node = soft.body->m_nodes[i];
            node.m_v += soft.VelocityMotionOf(size_t(i), node.m_x) / timeStep;
            node.m_vn = node.m_v;
            node.m_q = node.m_x = soft.positions[size_t(i)];
            moved = true;
        });
    if (!moved)
        return;
    soft.body->interpolateRenderMesh();
    // Bullet puts a body to sleep by its speed, which it has read before contacts took that of gravity.
    soft.body->m_maxSpeedSquared = 0;
    for (int i = 0; i < soft.body->m_nodes.size(); i++)
        soft.body->m_maxSpeedSquared = btMax(soft.body->m_maxSpeedSquared, soft.body->m_nodes[i].m_v.length2());
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
    m_implementation->elasticContacts.SetElasticity(std::make_unique<qcDeformableElasticity>(deformableSolver));
}

qcDeformableWorld::~qcDeformableWorld() = default;

/// The step of the base class without performDeformableCollisionDetection, applyRepulsionForce and
/// performGeometricCollisions; the contact callbacks come last.
void qcDeformableWorld::internalSingleStepSimulation(btScalar timeStep)
{
    if (m_internalPreTickCallback != nullptr)
        m_internalPreTickCallback(this, timeStep);
    m_implementation->BeginStep(getSoftBodyArray());
    m_implementation->scene.BeginStep(getSoftBodyArray());
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
    m_implementation->DispatchCallbacks();
}

void qcDeformableWorld::integrateTransforms(btScalar timeStep)
{
    Implementation& my = *m_implementation;
    // Bullet calls the tick and solver callbacks around the solver.
    my.scene.ReadBegin(getSoftBodyArray());
    my.ReadStart(getSoftBodyArray(), &btSoftBody::Node::m_x);
    // A body that falls asleep in this step has the velocity of gravity, and Bullet would still move it.
    for (int i = 0; i < getSoftBodyArray().size(); i++)
        if (!getSoftBodyArray()[i]->isActive())
            getSoftBodyArray()[i]->setZeroVelocity();
    btDeformableMultiBodyDynamicsWorld::integrateTransforms(timeStep);
    qcPresentObjects present(my.scene);
    my.elasticContacts.Solve(my.scene, &present, timeStep);
    if (!my.Resolve(timeStep))
        return;
    for (const qcSceneSoftBody& soft : my.scene.Bodies())
        MoveDeformableNodes(soft, timeStep);
    my.scene.ReadVelocities();
}
