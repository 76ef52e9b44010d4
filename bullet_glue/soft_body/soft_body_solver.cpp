// The soft-body solver of the classic world: Bullet's constraints, then contact.
#include "soft_body/contact_step.h"

namespace
{
/// Every node that is not where Bullet's own constraints left it goes to its place, with the velocity that leads there
/// from the start of the step, as btSoftBody::solveConstraints sets it.
void MoveNodes(const qcSceneSoftBody& known)
{
    const btScalar perDistance = known.body->m_sst.isdt * (1 - known.body->m_cfg.kDP);
    known.ForEachMoved(
        [&](int i)
        {
            btSoftBody::Node& node = known.body->m_nodes[i];
            node.m_x = known.places[size_t(i)];
            node.m_v = known.MotionOf(size_t(i), known.start[size_t(i)]) * perDistance;
        });
}
} // namespace

qcSoftBodySolver::qcSoftBodySolver(qcDevice* device) : qcSoftBodyContact(device)
{
    m_implementation->solvesLinks = true;
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
    if (!my.Resolve(timeStep))
        return;
    for (const qcSceneSoftBody& known : my.scene.Bodies())
        MoveNodes(known);
}

void qcSoftBodySolver::updateSoftBodies()
{
    // The last call of a step.
    btDefaultSoftBodySolver::updateSoftBodies();
    m_implementation->Tell();
}
