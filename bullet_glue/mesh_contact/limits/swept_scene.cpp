// The scene in which the motions of a step are certified.
#include "mesh_contact/limits/swept_scene.h"

#include "common/first_error.h"
#include "common/profiled_detect.h"

#include <algorithm>

qcSweptScene::~qcSweptScene()
{
    qcScene_Destroy(m_scene);
}

void qcSweptScene::CollectObjects()
{
    m_objects.clear();
    m_detection++;
    for (const qcSweptPair& pair : *m_pairs)
        for (qcSweptObject* swept : {pair.first, pair.second})
        {
            if (swept->detection != m_detection)
                m_objects.push_back(swept);
            swept->detection = m_detection;
        }
}

/// Brings the scene's meshes of an object up to date.
qcStatus qcSweptScene::AddMeshes(qcSweptObject* swept)
{
    const btCollisionShape* shape = swept->object->getCollisionShape();
    qcConvexCores* innerCores = swept->cores != nullptr ? swept->innerCores : nullptr;
    // Convex shapes join the meshes only while they may pass one: those that are there go on, with their motion.
    size_t sameCount = 0, count = 0;
    auto compare = [&](const btCollisionShape* simple, const btTransform& local, qcSweptPart part)
    {
        if (sameCount == count++ && sameCount < swept->meshes.size())
        {
            const qcSweptMesh& mesh = swept->meshes[sameCount];
            sameCount += mesh.part == part && mesh.shape == simple && qcAreSame(mesh.local, local) &&
                         mesh.revision == qcMeshRevision(simple);
        }
    };
    qcForEachSwept(shape, swept->cores, innerCores, compare);
    for (size_t i = sameCount; i < swept->meshes.size(); i++)
        swept->meshes[i].RemoveFrom(m_scene);
    swept->meshes.erase(swept->meshes.begin() + ptrdiff_t(sameCount), swept->meshes.end());
    if (sameCount < count)
    {
        const std::vector<qcSweptSource> present = qcCollectSwept(shape, swept->cores, innerCores);
        for (size_t i = sameCount; i < count; i++)
            swept->meshes.emplace_back(present[i], swept->body == nullptr);
    }
    for (size_t i = 0; i < swept->meshes.size(); i++)
    {
        qcSweptMesh& mesh = swept->meshes[i];
        if (mesh.id.generation != 0)
            continue;
        qcStatus status = mesh.AddTo(m_scene, swept->start, swept->number);
        if (status != qc_statusOk)
            return status;
        m_meshOfSlot.resize(std::max(m_meshOfSlot.size(), size_t(mesh.id.slot) + 1));
        m_meshOfSlot[mesh.id.slot] = {swept, i};
    }
    return qc_statusOk;
}

/// Places the meshes of all objects at the start or the end of the step.
qcStatus qcSweptScene::PlaceMeshes(bool atStart) const
{
    qcStatus status = qc_statusOk;
    for (qcSweptObject* swept : m_objects)
        for (qcSweptMesh& mesh : swept->meshes)
            status = qcFirstError(status, mesh.Place(m_scene, atStart ? swept->start : swept->end, atStart));
    return status;
}

bool qcSweptScene::TestPair(void* context, uint32_t slotA, uint32_t slotB)
{
    const auto* scene = static_cast<const qcSweptScene*>(context);
    const Side a = scene->SideOf(slotA), b = scene->SideOf(slotB);
    qcSweptPair pair(a.swept, b.swept);
    if (pair.first->number > pair.second->number)
        std::swap(pair.first, pair.second);
    if (!std::binary_search(scene->m_pairs->begin(), scene->m_pairs->end(), pair, qcIsBefore))
        return false;
    const qcSweptPart left = scene->m_inner->count(qcNumbersOf(pair)) > 0 ? qcSweptPart::core : qcSweptPart::innerCore;
    return a.mesh->part != left && b.mesh->part != left;
}

qcStatus qcSweptScene::Detect(const std::vector<qcSweptPair>& pairs, const std::set<qcPairNumbers>& inner,
                              const qcResult** result)
{
    m_pairs = &pairs;
    m_inner = &inner;
    qcStatus status = qc_statusOk;
    if (m_scene == nullptr)
    {
        qcSceneDef def = qcDefaultSceneDef();
        status = qcScene_Create(&def, &m_scene);
    }
    CollectObjects();
    for (qcSweptObject* swept : m_objects)
        status = status == qc_statusOk ? AddMeshes(swept) : status;
    if (status == qc_statusOk)
        status = PlaceMeshes(true);
    if (status == qc_statusOk)
        status = qcScene_MarkStart(m_scene);
    if (status == qc_statusOk)
        status = PlaceMeshes(false);
    if (status != qc_statusOk)
        return status;
    qcDetectDef def = qcProfiledDetectDef();
    def.method = qc_methodSweep;
    def.motion = true;
    def.proximities = true;
    def.threads = m_settings.threads;
    def.pairFilter = TestPair;
    def.pairFilterContext = this;
    return qcScene_Detect(m_scene, &def, result);
}

qcSweptScene::Side qcSweptScene::SideOf(uint32_t slot) const
{
    const auto& [swept, mesh] = m_meshOfSlot[slot];
    return {swept, &swept->meshes[mesh]};
}

qcPairNumbers qcSweptScene::NumbersOf(const qcPair& pair) const
{
    return std::minmax(SideOf(pair.bodyA).swept->number, SideOf(pair.bodyB).swept->number);
}

qcSweptTriangles qcSweptScene::TrianglesOf(const qcPair& pair, const qcProximity& atStart) const
{
    Side a = SideOf(pair.bodyA), b = SideOf(pair.bodyB);
    return {&pair, &atStart, {a.swept, a.mesh, pair.triangleA}, {b.swept, b.mesh, pair.triangleB}};
}
