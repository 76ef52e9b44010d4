// The soft-body solver of the classic world: Bullet's constraints, then contact.
#include "soft_body_contact.h"

namespace
{
/// The velocity that leads from the start of the step to the present position, as btSoftBody::solveConstraints sets it,
/// for every node that is not where Bullet's own constraints left it.
void UpdateVelocities(qcSoftBodyScene& scene, const std::vector<std::vector<btVector3>>& solved)
{
    for (size_t b = 0; b < scene.Bodies().size(); b++)
    {
        const qcSceneSoftBody& known = scene.Bodies()[b];
        const btScalar perDistance = known.body->m_sst.isdt * (1 - known.body->m_cfg.kDP);
        for (int i = 0; i < known.NodeCount(); i++)
        {
            btSoftBody::Node& node = known.body->m_nodes[i];
            if (node.m_x != solved[b][size_t(i)])
                node.m_v = (node.m_x - known.start[size_t(i)]) * perDistance;
        }
    }
}
} // namespace

qcSoftBodySolver::qcSoftBodySolver(qcDevice* device) : qcSoftBodyContact(device)
{
}

qcSoftBodySolver::~qcSoftBodySolver() = default;

void qcSoftBodySolver::optimize(btAlignedObjectArray<btSoftBody*>& softBodies, bool forceUpdate)
{
    // The first call of a step, before collision detection.
    m_implementation->Begin(softBodies);
    btDefaultSoftBodySolver::optimize(softBodies, forceUpdate);
}

void qcSoftBodySolver::processCollision(btSoftBody*, btSoftBody*)
{
    // Solved with all others after Bullet's own constraints, when positions are known.
}

void qcSoftBodySolver::solveConstraints(btScalar timeStep)
{
    Implementation& my = *m_implementation;
    // Here Bullet moves on from m_q; its constraints of drift write it anew.
    my.Start(m_softBodySet, &btSoftBody::Node::m_q);
    btDefaultSoftBodySolver::solveConstraints(timeStep);
    if (my.Resolve(timeStep))
        UpdateVelocities(my.scene, my.solved);
}

void qcSoftBodySolver::updateSoftBodies()
{
    // The last call of a step.
    btDefaultSoftBodySolver::updateSoftBodies();
    m_implementation->Tell();
}
