// The deformable world: Bullet's step with contact of ours in the place of its own.
//
// Bullet 3.24 has constraints between faces and nodes (btDeformableFaceNodeContactConstraint), but never makes one:
// btDeformableContactProjection::setConstraints does not read m_faceNodeContacts. It answers these with impulses of
// applyRepulsionForce, after the implicit solve, in an order drawn from a random seed that all worlds of a process
// share. So contact is a matter of positions here, as in the classic world.
#include "quickcullide/bullet_deformable.h"

#include "soft_body_contact.h"

namespace
{
/// Velocities, and what else Bullet keeps of positions, follow the nodes that contacts moved.
void FollowMoves(qcSoftBodyScene& scene, const std::vector<std::vector<btVector3>>& solved, btScalar timeStep)
{
    for (size_t b = 0; b < scene.Bodies().size(); b++)
    {
        btSoftBody* body = scene.Bodies()[b].body;
        bool moved = false;
        for (int i = 0; i < body->m_nodes.size(); i++)
        {
            btSoftBody::Node& node = body->m_nodes[i];
            const btVector3& before = solved[b][size_t(i)];
            if (node.m_x == before)
                continue;
            node.m_v += (node.m_x - before) / timeStep;
            node.m_vn = node.m_v;
            node.m_q = node.m_x;
            moved = true;
        }
        if (moved)
            body->interpolateRenderMesh();
    }
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
    if (my.Resolve(timeStep))
        FollowMoves(my.scene, my.solved, timeStep);
}
