// The soft-body solver of the classic world: contact follows Bullet's own constraints.
#include "soft_body/contact_step.h"

namespace
{
/// Writes the positions of the nodes that contacts moved, with the velocity that leads there from the start of the
/// step: btSoftBody::solveConstraints sets velocities in this way.
void MoveNodes(const qcSceneSoftBody& soft)
{
    const btScalar perDistance = soft.body->m_sst.isdt * (1 - soft.body->m_cfg.kDP);
    soft.ForEachMoved(
        [&](int i)
        {
            btSoftBody::Node& node = soft.body->m_nodes[i];
            node.m_x = soft.positions[size_t(i)];
            node.m_v = soft.MotionOf(size_t(i), soft.start[size_t(i)]) * perDistance;
        });
}
/// True if all that btSoftBody::solveConstraints does for the body is projection of positions.
bool HasPositionsOnly(const btSoftBody& body)
{
    return body.m_clusters.size() == 0 && body.m_anchors.size() == 0 && body.m_cfg.viterations <= 0;
}

/// `ramps`: the solvers get the part of the iterations that is done, and not 0.
void RunSolvers(btSoftBody* body, const btSoftBody::tPSolverArray& sequence, int iterations, bool ramps)
{
    for (int iteration = 0; iteration < iterations; iteration++)
        for (int i = 0; i < sequence.size(); i++)
            btSoftBody::getSolver(sequence[i])(body, 1, ramps ? btScalar(iteration) / btScalar(iterations) : 0);
}

/// Takes the steps of btSoftBody::solveConstraints, with the same result to the last bit, but without the two arrays
/// that Bullet allocates and clears twice for clusters that the body doesn't have: a tenth of its step with small
/// bodies.
void SolvePositions(btSoftBody* body)
{
    btSoftBody::tNodeArray& nodes = body->m_nodes;
    for (int i = 0; i < body->m_links.size(); i++)
    {
        btSoftBody::Link& link = body->m_links[i];
        link.m_c3 = link.m_n[1]->m_q - link.m_n[0]->m_q;
        link.m_c2 = 1 / (link.m_c3.length2() * link.m_c0);
    }
    const btSoftBody::Config& config = body->m_cfg;
    if (config.piterations > 0)
    {
        RunSolvers(body, config.m_psequence, config.piterations, true);
        const btScalar perDistance = body->m_sst.isdt * (1 - config.kDP);
        for (int i = 0; i < nodes.size(); i++)
        {
            nodes[i].m_v = (nodes[i].m_x - nodes[i].m_q) * perDistance;
            nodes[i].m_f = btVector3(0, 0, 0);
        }
    }
    if (config.diterations <= 0)
        return;
    for (int i = 0; i < nodes.size(); i++)
        nodes[i].m_q = nodes[i].m_x;
    RunSolvers(body, config.m_dsequence, config.diterations, false);
    const btScalar perDrift = config.kVCF * body->m_sst.isdt;
    for (int i = 0; i < nodes.size(); i++)
        nodes[i].m_v += (nodes[i].m_x - nodes[i].m_q) * perDrift;
}

/// What btDefaultSoftBodySolver::solveConstraints does.
void SolveBullets(const btAlignedObjectArray<btSoftBody*>& bodies)
{
    for (int i = 0; i < bodies.size(); i++)
        if (bodies[i]->isActive() && HasPositionsOnly(*bodies[i]))
            SolvePositions(bodies[i]);
        else if (bodies[i]->isActive())
            bodies[i]->solveConstraints();
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
    m_implementation->BeginStep(softBodies);
    btDefaultSoftBodySolver::optimize(softBodies, forceUpdate);
}

void qcSoftBodySolver::processCollision(btSoftBody*, btSoftBody*)
{
    // All contacts are solved together, after Bullet's own constraints have moved the nodes.
}

void qcSoftBodySolver::solveConstraints(btScalar timeStep)
{
    Implementation& my = *m_implementation;
    // m_q is where Bullet's step started from; its drift constraints overwrite it.
    my.ReadStart(m_softBodySet, &btSoftBody::Node::m_q);
    my.heldContacts.Insert(my.scene);
    SolveBullets(m_softBodySet);
    my.heldContacts.Remove(my.scene);
    if (!my.Resolve(timeStep))
        return;
    for (const qcSceneSoftBody& soft : my.scene.Bodies())
        MoveNodes(soft);
}

void qcSoftBodySolver::updateSoftBodies()
{
    // The last call of a step.
    btDefaultSoftBodySolver::updateSoftBodies();
    m_implementation->DispatchCallbacks();
}
