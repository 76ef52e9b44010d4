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
        std::vector<btVector3> byLinks;
        for (size_t i = 0; i < predicted.size(); i++)
            byLinks.push_back(soft.solved[i] - predicted[i]);
        soft.LimitLinks(byLinks, 2, [&](size_t i) { return predicted[i] - soft.VelocityStartOf(i); });
    }
}
