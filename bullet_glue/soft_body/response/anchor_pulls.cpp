#include "soft_body/response/anchor_pulls.h"

#include <algorithm>

namespace
{
qcRigidDisplacement VelocityOf(const btRigidBody& body)
{
    qcRigidDisplacement velocity;
    velocity.angular = body.getAngularVelocity();
    velocity.linear = body.getLinearVelocity();
    return velocity;
}
} // namespace

void qcAnchorPulls::Begin(const btAlignedObjectArray<btSoftBody*>& bodies)
{
    m_loads.clear();
    for (int i = 0; i < bodies.size(); i++)
        for (int j = 0; j < bodies[i]->m_anchors.size(); j++)
        {
            const btRigidBody* body = bodies[i]->m_anchors[j].m_body;
            auto isSame = [body](const Load& load) { return load.body == body; };
            if (body != nullptr && body->getInvMass() > 0 && std::none_of(m_loads.begin(), m_loads.end(), isSame))
                m_loads.push_back({body, VelocityOf(*body)});
        }
}

void qcAnchorPulls::End(btScalar timeStep)
{
    for (Load& load : m_loads)
    {
        const qcRigidDisplacement now = VelocityOf(*load.body);
        load.by.angular = (now.angular - load.by.angular) * timeStep;
        load.by.linear = (now.linear - load.by.linear) * timeStep;
    }
}

void qcAnchorPulls::Move(const std::vector<qcSoftConstraint>& constraints)
{
    for (const qcSoftConstraint& constraint : constraints)
    {
        qcSceneRigid* rigid = constraint.rigid;
        auto isTouched = [rigid](const Load& load) { return load.body == rigid->body; };
        const auto touched = rigid != nullptr ? std::find_if(m_loads.begin(), m_loads.end(), isTouched) : m_loads.end();
        if (touched == m_loads.end())
            continue;
        // Anchors take no notice of joints.
        if (!rigid->isGuided && !rigid->isFixed)
            rigid->MoveWithoutVelocity(touched->by);
        m_loads.erase(touched);
    }
}
