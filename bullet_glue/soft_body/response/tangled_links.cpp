#include "soft_body/response/tangled_links.h"

#include <algorithm>

void qcTangledLinks::Begin(qcSoftBodyScene& scene)
{
    m_predicted.assign(scene.Bodies().size(), {});
    for (size_t b = 0; b < m_predicted.size(); b++)
    {
        qcSceneSoftBody& soft = scene.Bodies()[b];
        for (int i = 0; soft.strainedSteps > 0 && i < soft.NodeCount(); i++)
            m_predicted[b].push_back(soft.body->m_nodes[i].m_x);
        soft.strainedSteps = std::max(soft.strainedSteps - 1, 0);
    }
}

void qcTangledLinks::LimitVelocities(qcSoftBodyScene& scene) const
{
    for (size_t b = 0; b < m_predicted.size(); b++)
    {
        qcSceneSoftBody& soft = scene.Bodies()[b];
        const std::vector<btVector3>& predicted = m_predicted[b];
        double work = 0, square = 0;
        for (size_t i = 0; i < predicted.size(); i++)
        {
            const btScalar inverseMass = soft.body->m_nodes[int(i)].m_im;
            if (!(inverseMass > 0))
                continue;
            const btVector3 by = soft.solved[i] - predicted[i], without = predicted[i] - soft.VelocityStartOf(i);
            work += double(by.dot(without) / inverseMass);
            square += double(by.length2() / inverseMass);
        }
        const double share = square > 0 ? std::min(std::max(-2 * work / square, 0.0), 1.0) : 1;
        if (!(share < 1))
            continue;
        soft.shifts.resize(soft.positions.size(), btVector3(0, 0, 0));
        for (size_t i = 0; i < predicted.size(); i++)
            soft.shifts[i] += (soft.solved[i] - predicted[i]) * btScalar(1 - share);
    }
}
