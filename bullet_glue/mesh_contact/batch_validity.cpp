// Decides whether the last batch holds for the pairs of a step.
#include "mesh_contact/batch_validity.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>

#include <algorithm>

/// True if the last gathering has all meshes of the object at their present transforms.
bool qcBatchValidity::IsValid(const btCollisionObject* object, const qcBatchObject& gathered)
{
    if (!m_scene.IsUpToDate(object, gathered))
        return false;
    // Fast objects were sampled along the velocities that they had.
    bool isFast = 2 * qcRigidMotion(object).MaxSpeed(gathered.radius) * m_scene.GetTimeStep() > gathered.threshold;
    if (isFast && !gathered.state.IsStateOf(object))
        return false;
    m_present.clear();
    qcCollectMeshes(object->getCollisionShape(), object->getWorldTransform(), &m_present);
    auto isCurrent = [](const qcBatchMesh& mesh, const qcBatchMesh& now)
    { return mesh.IsCurrent(now.shape, now.transform); };
    return std::equal(gathered.meshes.begin(), gathered.meshes.end(), m_present.begin(), m_present.end(), isCurrent);
}

/// Checks an object once a check. Null: it was never gathered.
const qcBatchObject* qcBatchValidity::CheckObject(const btCollisionObject* object)
{
    qcBatchObject* gathered = m_scene.Find(object);
    if (gathered != nullptr && gathered->checked != m_number)
    {
        gathered->checked = m_number;
        gathered->isValid = IsValid(object, *gathered);
        gathered->state = qcObjectState::Of(object);
    }
    return gathered;
}

bool qcBatchValidity::Check()
{
    m_number++;
    bool all = true;
    btDispatcher* dispatcher = m_scene.GetSettings().world->getDispatcher();
    m_scene.ForEachPair(
        [&](const btCollisionObject* object0, const btCollisionObject* object1)
        {
            const qcBatchObject *a = CheckObject(object0), *b = CheckObject(object1);
            bool gathered = a != nullptr && b != nullptr;
            bool isOurs = !gathered || (!a->meshes.empty() && !b->meshes.empty() && (a->isOurs || b->isOurs));
            if (!isOurs || !dispatcher->needsCollision(object0, object1))
                return;
            all = all && gathered && a->isValid && b->isValid &&
                  (a->activity == qc_activityMoving || b->activity == qc_activityMoving);
        });
    return all;
}

bool qcBatchValidity::IsAsChecked(const btCollisionObject* object) const
{
    const qcBatchObject* gathered = static_cast<const qcBatchScene&>(m_scene).Find(object);
    return gathered != nullptr && gathered->checked == m_number && gathered->state.IsStateOf(object);
}
