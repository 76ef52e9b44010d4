// The leaves in the live window: their settings and colours.
#include "leaves/viewed.h"

#include <BulletSoftBody/btSoftBody.h>

qcViewedLeaves::qcViewedLeaves(const qcLeavesRequest& request, qcDevice* device) : m_request(request), m_devices(device)
{
    MakeWorld();
}

void qcViewedLeaves::MakeWorld()
{
    m_world = std::make_unique<qcLeavesWorld>(m_request, m_devices.Present());
}

bool qcViewedLeaves::Step(std::string* message)
{
    m_costs = m_world->Step();
    if (m_world->Statistics().status == qc_statusOk)
        return true;
    *message = qcLastMessage();
    return false;
}

std::vector<qcViewStatistic> qcViewedLeaves::Statistics() const
{
    std::vector<qcViewStatistic> statistics = qcSoftStatistics(m_world->Statistics());
    statistics.push_back({"leaves on the tree", std::to_string(m_world->HangingCount())});
    return statistics;
}

std::vector<qcViewSetting> qcViewedLeaves::Settings()
{
    return {qcMethodSetting([this] { return m_request.method; },
                            [this](qcMethod method)
                            {
                                m_request.method = method;
                                m_world->SoftSolver().setMethod(method);
                            }),
            m_devices.Setting([this] { MakeWorld(); }),
            qcThicknessSetting(m_world->Bullet(), m_world->SoftSolver(), 0.02),
            qcMarginSetting(m_world->Bullet(), 0.02)};
}

bool qcViewedLeaves::ColorsOf(const btCollisionObject* object, qcViewColors* colors) const
{
    // Autumn.
    static const float leaves[4][3] = {
        {0.62f, 0.33f, 0.05f}, {0.55f, 0.16f, 0.05f}, {0.60f, 0.46f, 0.09f}, {0.27f, 0.33f, 0.07f}};
    if (const btSoftBody* leaf = btSoftBody::upcast(object))
    {
        const float* c = leaves[size_t(leaf->getBroadphaseHandle()->m_uniqueId) % 4];
        *colors = {{c[0], c[1], c[2]}, {0.75f * c[0] + 0.08f, 0.75f * c[1] + 0.07f, 0.75f * c[2] + 0.05f}};
    }
    else
        *colors = {{0.16f, 0.11f, 0.075f}, {0.16f, 0.11f, 0.075f}};
    return true;
}

qcViewPlace qcViewedLeaves::Place() const
{
    qcViewPlace place;
    place.eye = btVector3(btScalar(1.5), btScalar(2.6), btScalar(7.8));
    place.target = btVector3(0, btScalar(1.4), 0);
    return place;
}
