// Contact of the soft bodies of a world, as applications set it up.
#include "soft_body/contact_step.h"

#include "quickcullide/bullet_debug_draw.h"

#include <cmath>

qcSoftBodyContact::qcSoftBodyContact(qcDevice* device) : m_implementation(new Implementation(device))
{
}

qcSoftBodyContact::~qcSoftBodyContact() = default;

qcStatus qcSoftBodyContact::setSettings(const btSoftBody* body, const qcSoftBodySettings& settings)
{
    const btScalar friction = settings.friction == -1 ? btScalar(0) : settings.friction;
    for (btScalar value : {settings.thickness, friction})
        if (!(value >= 0 && std::isfinite(value)))
            return qcFail(qc_statusBadInput, "qcSoftBodyContact::setSettings: thickness or friction is %g",
                          double(value));
    if (body == nullptr)
        return qcFail(qc_statusBadInput, "qcSoftBodyContact::setSettings: body is null");
    m_implementation->scene.SetSettings(body, settings);
    return qc_statusOk;
}

qcSoftBodySettings qcSoftBodyContact::getSettings(const btSoftBody* body) const
{
    return m_implementation->scene.GetSettings(body);
}

const qcSoftBodyStatistics& qcSoftBodyContact::getStatistics() const
{
    return m_implementation->statistics;
}

void qcSoftBodyContact::debugDraw(btIDebugDraw* drawer) const
{
    m_implementation->Draw(qc_drawPcs | qc_drawPlanes, drawer);
}

void qcSoftBodyContact::debugDraw(btIDebugDraw* drawer, int modes) const
{
    m_implementation->Draw(modes, drawer);
}

void qcSoftBodyContact::setReportCandidates(bool report)
{
    m_implementation->scene.reportsCandidates = report;
}

void qcSoftBodyContact::updateShape(const btCollisionShape* shape)
{
    m_implementation->scene.meshes.InvalidateShape(shape);
}

void qcSoftBodyContact::setThreadCount(unsigned threads)
{
    m_implementation->scene.threads = threads;
}

void qcSoftBodyContact::setMethod(qcMethod method)
{
    m_implementation->scene.method = method;
}
