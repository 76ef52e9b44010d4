// The soft-body solver of the classic world: contact follows Bullet's own constraints.
#include "soft_body/contact_step.h"
#include "soft_body/response/link_elasticity.h"

namespace
{
/// Writes the positions of the nodes that contacts moved, with the velocity that leads there from where Bullet's step
/// started: btSoftBody::solveConstraints sets velocities in this way.
void MoveNodes(const qcSceneSoftBody& soft)
{
    const btScalar perDistance = soft.body->m_sst.isdt * (1 - soft.body->m_cfg.kDP);
    soft.ForEachMoved(
        [&](int i)
        {
            btSoftBody::Node& node = soft.body->m_nodes[i];
            node.m_x = soft.positions[size_t(i)];
            node.m_v = soft.VelocityMotionOf(size_t(i), soft.VelocityStartOf(size_t(i))) * perDistance;
        });
}
/// Puts the nodes back to where Bullet's step started.
void ReturnNodes(btSoftBody* body)
{
    for (int i = 0; i < body->m_nodes.size(); i++)
    {
        btSoftBody::Node& node = body->m_nodes[i];
        node.m_x = node.m_q;
        btDbvtVolume box = btDbvtVolume::FromCR(node.m_x, body->m_sst.radmrg);
        body->m_ndbvt.update(node.m_leaf, box);
    }
    body->updateBounds();
}
} // namespace

qcSoftBodySolver::qcSoftBodySolver(qcDevice* device) : qcSoftBodyContact(device)
{
    m_implementation->solvesLinks = true;
    m_implementation->elasticContacts.SetElasticity(std::make_unique<qcLinkElasticity>());
}

qcSoftBodySolver::~qcSoftBodySolver() = default;

void qcSoftBodySolver::optimize(btAlignedObjectArray<btSoftBody*>& softBodies, bool forceUpdate)
{
    // The first call of a step, before collision detection.
    m_implementation->BeginStep(softBodies);
    btDefaultSoftBodySolver::optimize(softBodies, forceUpdate);
}

void qcSoftBodySolver::predictMotion(btScalar timeStep)
{
    // Bullet has called the pre-tick callback since, and integrates later.
    m_implementation->scene.BeginStep(m_softBodySet);
    m_implementation->predicted.clear();
    for (int i = 0; i < m_softBodySet.size(); i++)
        if (m_softBodySet[i]->isActive())
            m_implementation->predicted.insert(m_softBodySet[i]);
    btDefaultSoftBodySolver::predictMotion(timeStep);
}

void qcSoftBodySolver::processCollision(btSoftBody*, btSoftBody*)
{
    // All contacts are solved together, after Bullet's own constraints have moved the nodes.
}

void qcSoftBodySolver::solveConstraints(btScalar timeStep)
{
    Implementation& my = *m_implementation;
    // Bullet lets bodies fall asleep in the middle of a step: neither constraints nor contact would hold these.
    for (int i = 0; i < m_softBodySet.size(); i++)
        if (m_softBodySet[i]->getActivationState() == ISLAND_SLEEPING && my.predicted.count(m_softBodySet[i]) > 0)
            ReturnNodes(m_softBodySet[i]);
    my.predicted.clear();
    // m_q is where Bullet's step started from; its drift constraints overwrite it.
    my.ReadStart(m_softBodySet, &btSoftBody::Node::m_q);
    qcPresentObjects present(my.scene);
    my.elasticContacts.ReadPredicted(my.scene);
    my.heldContacts.Insert(my.scene, &present);
    my.tangledLinks.Begin(my.scene);
    my.anchorPulls.Begin(m_softBodySet);
    btDefaultSoftBodySolver::solveConstraints(timeStep);
    my.anchorPulls.End(timeStep);
    my.heldContacts.Remove(my.scene);
    my.elasticContacts.Solve(my.scene, &present, timeStep);
    if (!my.Resolve(timeStep))
        return;
    for (const qcSceneSoftBody& soft : my.scene.Bodies())
        MoveNodes(soft);
    my.scene.ReadVelocities();
}

void qcSoftBodySolver::updateSoftBodies()
{
    // The last call of a step.
    btDefaultSoftBodySolver::updateSoftBodies();
    m_implementation->DispatchCallbacks();
}
