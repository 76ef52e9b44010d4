// The scene in which the motions of a step are certified.
#include "mesh_contact/limits/swept_scene.h"

#include "common/first_error.h"
#include "common/profiled_detect.h"

#include <LinearMath/btAabbUtil2.h>

#include <algorithm>

namespace
{
// Up to so many children of a compound are in the scene, near or not: a search takes as long.
constexpr size_t s_fewChildren = 64;
// Upper bound of the rounding of a box in another frame, as a part of the lengths that take part.
constexpr btScalar s_boxError = 64 * SIMD_EPSILON;

/// True if the scene holds only those meshes of a compound that other objects may meet.
bool HoldsNearOnly(const qcSweptObject& swept)
{
    return !swept.IsFree() && !swept.moves && swept.children.AreRead() && swept.children.AreAll() &&
           swept.children.Count() > s_fewChildren;
}

/// Adds the children of a compound that stays whose boxes meet that of the other object.
void AddNearChildren(const qcSweptObject& other, qcSweptObject* still)
{
    if (!HoldsNearOnly(*still))
        return;
    const btVector3 half = (other.upper - other.lower) / 2, centre = other.lower + half;
    const btVector3& origin = still->start.getOrigin();
    const btScalar error = s_boxError * (half.length() + centre.length() + origin.length() + still->children.Radius());
    // Bases are orthogonal only up to rounding, and what the application has set.
    const btMatrix3x3 back = still->start.getBasis().inverse();
    btVector3 lower, upper;
    btTransformAabb(half, error, btTransform(back, back * (centre - origin)), lower, upper);
    still->children.VisitBox(lower, upper, [still](size_t child) { still->nearChildren.push_back(uint32_t(child)); });
}

/// Removes numbers that are there twice, of those from `known` on; sorts these.
void RemoveRepeated(size_t known, std::vector<uint32_t>* numbers)
{
    const auto first = numbers->begin() + ptrdiff_t(known);
    std::vector<uint32_t> before(numbers->begin(), first);
    std::sort(before.begin(), before.end());
    std::sort(first, numbers->end());
    numbers->erase(std::unique(first, numbers->end()), numbers->end());
    numbers->erase(std::remove_if(first, numbers->end(),
                                  [&before](uint32_t number)
                                  { return std::binary_search(before.begin(), before.end(), number); }),
                   numbers->end());
}

/// Calls function(mesh, transform, part) for what the scene holds of an object; see qcForEachSwept.
template <typename Function> void ForEachHeld(const qcSweptObject& swept, const Function& function)
{
    qcConvexCores* innerCores = swept.cores != nullptr ? swept.innerCores : nullptr;
    if (!HoldsNearOnly(swept))
    {
        qcForEachSwept(swept.object->getCollisionShape(), swept.cores, innerCores, function);
        return;
    }
    // The application may move the triangles of any mesh.
    for (size_t i = 0; i < swept.children.MeshCount(); i++)
        function(swept.children[i].mesh, swept.children[i].local, qcSweptPart::mesh);
    for (qcSweptPart part : {qcSweptPart::core, qcSweptPart::innerCore})
        for (uint32_t i : swept.nearChildren)
        {
            const qcSweptChildren::Child& child = swept.children[i];
            if (child.convex == nullptr || (part == qcSweptPart::innerCore && innerCores == nullptr))
                continue;
            const qcMeshShape* mesh =
                part == qcSweptPart::core ? child.mesh : innerCores->Find(child.convex).mesh.get();
            if (mesh != nullptr)
                function(mesh, child.local, part);
        }
}
} // namespace

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

/// Finds the children of large compounds at rest that other objects may meet.
void qcSweptScene::FindNearChildren() const
{
    for (qcSweptObject* swept : m_objects)
        if (!swept->IsFree())
            swept->ReadChildren();
    std::vector<size_t> known; // by object, how many are of earlier rounds: they keep their places in the scene
    for (const qcSweptObject* swept : m_objects)
        known.push_back(swept->nearChildren.size());
    for (const qcSweptPair& pair : *m_pairs)
    {
        AddNearChildren(*pair.first, pair.second);
        AddNearChildren(*pair.second, pair.first);
    }
    for (size_t i = 0; i < m_objects.size(); i++)
        RemoveRepeated(known[i], &m_objects[i]->nearChildren);
}

/// Adds a mesh of an object to the scene, unless it is there.
qcStatus qcSweptScene::AddMesh(qcSweptObject* swept, size_t index)
{
    qcSweptMesh& mesh = swept->meshes[index];
    if (mesh.id.generation != 0)
        return qc_statusOk;
    const qcStatus status = mesh.AddTo(m_scene, swept->start, swept->number);
    if (status != qc_statusOk)
        return status;
    m_meshOfSlot.resize(std::max(m_meshOfSlot.size(), size_t(mesh.id.slot) + 1));
    m_meshOfSlot[mesh.id.slot] = {swept, index};
    return qc_statusOk;
}

/// Brings the scene's meshes of an object up to date.
qcStatus qcSweptScene::AddMeshes(qcSweptObject* swept)
{
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
    ForEachHeld(*swept, compare);
    for (size_t i = sameCount; i < swept->meshes.size(); i++)
        swept->meshes[i].RemoveFrom(m_scene);
    swept->meshes.erase(swept->meshes.begin() + ptrdiff_t(sameCount), swept->meshes.end());
    size_t number = 0;
    auto add = [&](const btCollisionShape* simple, const btTransform& local, qcSweptPart part)
    {
        if (number++ >= sameCount)
            swept->meshes.emplace_back(qcMakeSweptSource(simple, local, part), swept->body == nullptr);
    };
    if (sameCount < count)
        ForEachHeld(*swept, add);
    qcStatus status = qc_statusOk;
    const size_t meshCount = HoldsNearOnly(*swept) ? swept->children.MeshCount() : 0;
    for (uint32_t child : swept->nearChildren)
        if (child < meshCount)
            status = qcFirstError(status, AddMesh(swept, child));
    for (size_t i = meshCount; i < swept->meshes.size(); i++)
        status = qcFirstError(status, AddMesh(swept, i));
    return status;
}

/// Places the meshes of all objects at the start or the end of the step.
qcStatus qcSweptScene::PlaceMeshes(bool atStart) const
{
    qcStatus status = qc_statusOk;
    for (qcSweptObject* swept : m_objects)
        for (qcSweptMesh& mesh : swept->meshes)
            if (mesh.id.generation != 0)
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
    FindNearChildren();
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
