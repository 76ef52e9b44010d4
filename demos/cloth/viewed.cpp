// The cloth in the live window: its settings, names and colours.
#include "cloth/viewed.h"

qcViewedCloth::qcViewedCloth(unsigned triangleCount, qcDevice* device, qcMethod method, unsigned threads)
    : m_triangleCount(triangleCount), m_threads(threads), m_method(method), m_devices(device)
{
    m_world = std::make_unique<qcClothWorld>(triangleCount, true, device, method, threads);
    m_settings = m_world->SoftSolver().getSettings(&m_world->Cloth());
    m_margin = m_world->Cloth().getCollisionShape()->getMargin();
}

/// Gives the settings to the world.
void qcViewedCloth::Apply()
{
    m_world->SoftSolver().setMethod(m_method);
    m_world->SoftSolver().setSettings(&m_world->Cloth(), m_settings);
    m_world->Cloth().getCollisionShape()->setMargin(m_margin);
    m_world->Table().getCollisionShape()->setMargin(m_margin);
}

void qcViewedCloth::Restart()
{
    m_world = std::make_unique<qcClothWorld>(m_triangleCount, true, m_devices.Present(), m_method, m_threads);
    m_isPulled = false;
    Apply();
}

/// A new world on the present device, with the cloth where it is.
void qcViewedCloth::ChangeDevice()
{
    std::unique_ptr<qcClothWorld> before = std::move(m_world);
    Restart();
    for (int i = 0; i < before->Cloth().m_nodes.size(); i++)
    {
        const btSoftBody::Node& from = before->Cloth().m_nodes[i];
        btSoftBody::Node& to = m_world->Cloth().m_nodes[i];
        to.m_x = from.m_x;
        to.m_q = from.m_q;
        to.m_v = from.m_v;
    }
    m_world->Cloth().updateNormals();
    m_world->Cloth().updateBounds();
}

bool qcViewedCloth::Step(std::string* message)
{
    m_costs = m_world->Step();
    if (m_world->Statistics().status == qc_statusOk)
        return true;
    *message = qcLastMessage();
    return false;
}

std::vector<qcViewSetting> qcViewedCloth::Settings()
{
    auto number = [this](const char* label, double lowest, double highest, const char* format, btScalar* value)
    {
        return qcNumberSetting(
            label, lowest, highest, format, [value] { return double(*value); },
            [this, value](double chosen)
            {
                *value = btScalar(chosen);
                Apply();
            });
    };
    double edge = 2 / std::sqrt(m_triangleCount / 2.0);
    return {qcMethodSetting([this] { return m_method; },
                            [this](qcMethod method)
                            {
                                m_method = method;
                                Apply();
                            }),
            m_devices.Setting([this] { ChangeDevice(); }),
            number("thickness", 0.1 * edge, 0.8 * edge, "%.4f m", &m_settings.thickness),
            number("margin", 0.001, 0.03, "%.4f m", &m_margin),
            number("friction", 0, 1, "%.2f", &m_settings.friction),
            qcFlagSetting(
                "pulled away", [this] { return m_isPulled; },
                [this](bool on)
                {
                    if (on && !m_isPulled)
                        m_world->PullAway();
                    m_isPulled = m_isPulled || on;
                }),
            qcFlagSetting(
                "self-collision", [this] { return m_settings.selfCollision; },
                [this](bool on)
                {
                    m_settings.selfCollision = on;
                    Apply();
                })};
}

std::string qcViewedCloth::NameOf(const btCollisionObject* object) const
{
    if (object == &m_world->Cloth())
        return "the cloth";
    return object == &m_world->Table() ? "the table" : "";
}

bool qcViewedCloth::ColorsOf(const btCollisionObject* object, qcViewColors* colors) const
{
    if (object == &m_world->Cloth())
        // The upper side of Bullet's patch is its back.
        *colors = {{0.10f, 0.28f, 0.55f}, {0.70f, 0.33f, 0.09f}};
    else
        *colors = {{0.30f, 0.17f, 0.09f}, {0.30f, 0.17f, 0.09f}};
    return true;
}

qcViewPlace qcViewedCloth::Place() const
{
    qcViewPlace place;
    place.eye = btVector3(btScalar(1.9), btScalar(1.85), btScalar(2.5));
    place.target = btVector3(btScalar(0.05), btScalar(0.42), 0);
    return place;
}
