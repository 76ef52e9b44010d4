// The bunny and the breaking dragon in the live window: their settings and statistics.
#include "breaking/viewed.h"

qcViewedBreaking::qcViewedBreaking(const qcBreakingModel& model, qcMethod method, uint32_t threads, qcDevice* device)
    : m_model(model), m_method(method), m_threads(threads), m_devices(device)
{
    MakeWorld();
}

void qcViewedBreaking::MakeWorld()
{
    m_step = qcBreakingStep();
    m_world = std::make_unique<qcBreakingWorld>(m_model, m_method, m_threads, m_devices.Present());
}

bool qcViewedBreaking::Step(std::string* message)
{
    m_step = qcBreakingStep();
    return m_world->Step(&m_step, message);
}

std::vector<qcViewStatistic> qcViewedBreaking::Statistics() const
{
    return {{"queries by", qcMethod_Name(m_step.method)},
            {"drops", std::to_string(m_world->Drops())},
            {"loose pieces", std::to_string(m_step.loosePieces)},
            {"limited, unproven", std::to_string(m_step.limited) + ", " + std::to_string(m_step.unproven)}};
}

std::vector<qcViewSetting> qcViewedBreaking::Settings()
{
    return {qcMethodSetting([this] { return m_method; },
                            [this](qcMethod method)
                            {
                                m_method = method;
                                m_world->MeshContact().setMethod(method);
                            }),
            m_devices.Setting([this] { MakeWorld(); }), qcMarginSetting(m_world->Bullet(), 0.03)};
}

qcViewPlace qcViewedBreaking::Place() const
{
    qcViewPlace place;
    place.eye = btVector3(btScalar(2.8), btScalar(4.8), btScalar(13.5));
    place.target = btVector3(0, btScalar(2.1), 0);
    return place;
}
