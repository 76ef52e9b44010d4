// One body for each bounded surface, in the order of the surfaces.
#include "view/culling.h"

#include "common/bullet/body_transform.h"

#include <algorithm>
#include <cstring>

qcViewCulling::~qcViewCulling()
{
    qcScene_Destroy(m_scene);
}

bool qcViewCulling::Check(qcStatus status, std::string* message)
{
    if (status != qc_statusOk)
        *message = qcLastMessage();
    return status == qc_statusOk;
}

bool qcViewCulling::Add(const qcViewSurface& surface, Body* body, std::string* message)
{
    body->triangles = surface.triangles->id;
    body->id = qcBodyId{0, 0};
    if (surface.unbounded || surface.triangles->indices.empty())
        return true;
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = surface.triangles->positions.data();
    def.vertexCount = uint32_t(surface.triangles->positions.size() / 3);
    def.indices = surface.triangles->indices.data();
    def.triangleCount = uint32_t(surface.triangles->indices.size() / 3);
    def.deforming = surface.deforming;
    if (!surface.deforming)
        def.transform = qcBodyTransformOf(surface.place);
    def.activity = surface.object->isStaticObject() ? qc_activityStatic : qc_activityMoving;
    def.owner = surface.number + 1;
    def.selfCollision = surface.deforming;
    return Check(qcScene_AddBody(m_scene, &def, &body->id), message);
}

/// Makes the scene's bodies those of the surfaces, at their present places.
bool qcViewCulling::Sync(const std::vector<qcViewSurface>& surfaces, std::string* message)
{
    for (size_t i = 0; i < surfaces.size(); i++)
    {
        const qcViewSurface& surface = surfaces[i];
        if (i == m_bodies.size())
            m_bodies.push_back({0, {0, 0}});
        Body& body = m_bodies[i];
        if (body.triangles != surface.triangles->id)
        {
            if (body.id.generation != 0)
                qcScene_RemoveBody(m_scene, body.id);
            if (!Add(surface, &body, message))
                return false;
        }
        else if (body.id.generation != 0 && surface.deforming)
        {
            if (!Check(qcScene_SetVertices(m_scene, body.id, surface.triangles->positions.data(), qc_positionF32, 0),
                       message))
                return false;
        }
        else if (body.id.generation != 0)
        {
            qcTransform place = qcBodyTransformOf(surface.place);
            if (!Check(qcScene_SetTransform(m_scene, body.id, &place), message))
                return false;
        }
    }
    for (; m_bodies.size() > surfaces.size(); m_bodies.pop_back())
        if (m_bodies.back().id.generation != 0)
            qcScene_RemoveBody(m_scene, m_bodies.back().id);
    return true;
}

void qcViewCulling::Read(const qcResult& result, const std::vector<qcViewSurface>& surfaces)
{
    std::vector<size_t> surfaceOf;
    for (size_t i = 0; i < surfaces.size(); i++)
        if (m_bodies[i].id.generation != 0)
        {
            surfaceOf.resize(std::max(surfaceOf.size(), size_t(m_bodies[i].id.slot) + 1));
            surfaceOf[m_bodies[i].id.slot] = i;
        }
    m_marked.clear();
    m_sets = qcViewSets();
    m_sets.pairs = result.pairCount;
    m_sets.resolution = result.profile.resolution;
    m_sets.ms = result.profile.totalMs;
    for (size_t i = 0; i < result.pcsCount && result.pcsSets != nullptr; i++)
    {
        auto set = qcVisibilitySet(std::max(result.pcsSets[i].others, result.pcsSets[i].self));
        uint32_t& size = set == qc_setFfv ? m_sets.ffv : set == qc_setSfv ? m_sets.sfv : m_sets.nfv;
        size++;
        m_marked.push_back({surfaceOf[result.pcs[i].body], result.pcs[i].triangle, set});
    }
}

bool qcViewCulling::Run(const std::vector<qcViewSurface>& surfaces, const qcViewRequest& request, std::string* message)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    sceneDef.device = m_device;
    if (m_scene == nullptr && !Check(qcScene_Create(&sceneDef, &m_scene), message))
        return false;
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodQuick;
    def.resolution = 1u << request.resolutionPower;
    def.iterations = uint32_t(request.rounds);
    std::memset(def.views, 0, sizeof def.views);
    std::memcpy(def.views, qcViewAxes[request.views], std::strlen(qcViewAxes[request.views]));
    def.sets = true;
    const qcResult* result;
    if (!Sync(surfaces, message) || !Check(qcScene_Detect(m_scene, &def, &result), message))
        return false;
    if (result->profile.method != qc_methodQuick)
    {
        *message = std::string("Quick-CULLIDE does not run here: ") + result->profile.fallback;
        return false;
    }
    Read(*result, surfaces);
    return true;
}
