// The breaking body in the live window: its settings and statistics.
#include "fracture/viewed.h"

#include <cstdio>

qcViewedFracture::qcViewedFracture(const qcFractureModel& model, const qcFractureRequest& request, qcDevice* device)
    : m_model(model), m_request(request), m_devices(device)
{
    MakeWorld();
}

void qcViewedFracture::MakeWorld()
{
    m_step = qcFractureStep();
    m_world = std::make_unique<qcFractureWorld>(m_model, m_request, m_devices.Present());
    m_margin = double(m_world->Bodies().front()->shape.getMargin());
}

bool qcViewedFracture::Step(std::string* message)
{
    m_step = qcFractureStep();
    return m_world->Step(&m_step, message);
}

std::vector<qcViewStatistic> qcViewedFracture::Statistics() const
{
    char depth[32];
    std::snprintf(depth, sizeof depth, "%.2f mm", 1000 * double(m_step.penetration));
    return {{"queries by", qcMethod_Name(m_step.method)},
            {"pieces", std::to_string(m_step.bodies)},
            {"awake", std::to_string(m_step.awake)},
            {"deepest penetration", depth}};
}

std::vector<qcViewSetting> qcViewedFracture::Settings()
{
    auto setMargin = [this](double margin)
    {
        m_margin = margin;
        for (const auto& body : m_world->Bodies())
            body->shape.setMargin(btScalar(margin));
    };
    return {qcMethodSetting([this] { return m_request.method; },
                            [this](qcMethod method)
                            {
                                m_request.method = method;
                                m_world->MeshContact().setMethod(method);
                            }),
            m_devices.Setting([this] { MakeWorld(); }),
            qcNumberSetting(
                "margin", 0.001, 0.05, "%.3f m", [this] { return m_margin; }, setMargin),
            qcNumberSetting(
                "cells", 2, 1000, "%.0f", [this] { return double(m_request.pieces); },
                [this](double cells)
                {
                    m_request.pieces = unsigned(cells);
                    MakeWorld();
                })};
}

qcViewPlace qcViewedFracture::Place() const
{
    qcViewPlace place;
    place.eye = btVector3(btScalar(3.5), btScalar(6.5), 12);
    place.target = btVector3(0, btScalar(1.5), 0);
    return place;
}
