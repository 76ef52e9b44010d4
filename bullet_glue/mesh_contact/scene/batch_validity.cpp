// Decides which pairs of a step have to be queried.
#include "mesh_contact/scene/batch_validity.h"

#include "common/object_motion.h"
#include "common/parallel_loop.h"
#include "mesh_contact/scene/box_gap.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>

#include <algorithm>

namespace
{
// Pairs that a thread takes at a time, each of some tenths of a microsecond.
constexpr size_t s_checkBlock = 256;
} // namespace

bool qcBatchValidity::IsChanged(const btCollisionObject* object, qcBatchObject* gathered) const
{
    if (m_scene.Refresh(object, gathered))
        return true;
    // Fast objects were sampled along the velocities that they had.
    bool isFast = 2 * qcRigidMotion(object).MaxSpeed(gathered->boxRadius) * m_scene.GetTimeStep() > gathered->threshold;
    return isFast && !gathered->state.IsStateOf(object);
}

/// Checks an object once a check.
qcBatchObject* qcBatchValidity::CheckObject(const btCollisionObject* object)
{
    qcBatchObject* gathered = m_scene.FindOrAdd(object);
    if (gathered->checked != m_number)
    {
        gathered->isChanged = IsChanged(object, gathered);
        gathered->checked = m_number;
        gathered->isFinite = qcIsFinite(*object);
        gathered->state = qcObjectState::Of(object);
        gathered->maxClosing = m_scene.MaxClosing(object, *gathered);
    }
    return gathered;
}

/// True if the points of a pair are those that contact of the present step needs. `a` was added before `b`.
bool qcBatchValidity::Holds(const qcPairContact& pair, const qcBatchObject& a, const qcBatchObject& b) const
{
    // A pair that the previous check left out may have been fast then. An impulse since the query may have made the
    // objects faster.
    return pair.isKnown && pair.checked + 1 == m_number && !a.isChanged && !b.isChanged &&
           std::min({a.maxContactDistance, b.maxContactDistance, a.maxClosing + b.maxClosing}) <= pair.reach &&
           qcRelativeDisplacementBound({pair.a, a.state.transform, a.radius}, {pair.b, b.state.transform, b.radius}) <=
               a.tolerance + b.tolerance;
}

/// Upper bound of the distance by which the objects may close in on each other in the step, also if others stop one of
/// them.
btScalar qcBatchValidity::MaxTravel(const qcBatchPair& pair) const
{
    const qcBatchObject &a = *pair.gathered0, &b = *pair.gathered1;
    qcRigidMotion motionA(pair.object0), motionB(pair.object1);
    bool isSmallA = a.radius < b.radius;
    // Relative to each other they move fastest where the smaller one is.
    const btVector3& centre = isSmallA ? motionA.centre : motionB.centre;
    const btScalar relative = qcMaxSpeedBetween(motionA, motionB, centre, std::min(a.radius, b.radius));
    return std::max({relative, motionA.MaxSpeed(a.radius), motionB.MaxSpeed(b.radius)}) * m_scene.GetTimeStep();
}

/// True if the meshes of a pair are so far apart, as they were when it was queried or by their boxes, that they have no
/// contact in the step. What is known of the pair is then that.
bool qcBatchValidity::AreFar(const qcBatchPair& pair, qcPairContact* contact) const
{
    const qcBatchObject &a = *pair.gathered0, &b = *pair.gathered1;
    if (m_scene.GetTimeStep() <= 0)
        return false;
    btScalar threshold = std::min(a.threshold, b.threshold), rest = qcBatchScene::s_restDistance * threshold;
    btScalar needed = std::max({rest + MaxTravel(pair), std::min(threshold, rest + a.maxClosing + b.maxClosing),
                                a.maxContactDistance, b.maxContactDistance});
    btScalar gap = 0, margins = a.margin + b.margin;
    if (contact->versionA == a.version && contact->versionB == b.version)
        gap =
            qcGapAfter(*contact, {contact->a, a.state.transform, a.radius}, {contact->b, b.state.transform, b.radius});
    if (!(gap > needed + margins))
    {
        gap = qcBoxGap({a.lower, a.upper, a.state.transform}, {b.lower, b.upper, b.state.transform});
        margins = a.tolerance + b.tolerance;
    }
    if (!(gap > needed + margins))
        return false;
    *contact = qcPairContact();
    contact->isKnown = true;
    contact->versionA = a.version;
    contact->versionB = b.version;
    contact->a = a.state.transform;
    contact->b = b.state.transform;
    contact->reach = gap - margins;
    contact->gap = double(gap);
    return true;
}

/// Collects the pairs of the world that the library computes.
void qcBatchValidity::CollectPairs()
{
    m_present.clear();
    m_notFinite = nullptr;
    btDispatcher* dispatcher = m_scene.GetSettings().world->getDispatcher();
    m_scene.ForEachPair(
        [&](const btCollisionObject* object0, const btCollisionObject* object1)
        {
            qcBatchObject *a = CheckObject(object0), *b = CheckObject(object1);
            if (!a->isFinite || !b->isFinite)
            {
                m_notFinite = a->isFinite ? object1 : object0;
                return;
            }
            if (!a->MeetsHere(*b) || !dispatcher->needsCollision(object0, object1))
                return;
            if (a->owner > b->owner)
            {
                std::swap(a, b);
                std::swap(object0, object1);
            }
            m_present.push_back({object0, object1, a, b});
            m_pairs.FindOrAdd(a->owner, b->owner);
        });
}

bool qcBatchValidity::Check()
{
    m_number++;
    CollectPairs();
    std::vector<const qcPairContact*> contacts(m_present.size());
    auto checkPair = [&](size_t i, uint32_t)
    {
        const qcBatchPair& present = m_present[i];
        const qcBatchObject &a = *present.gathered0, &b = *present.gathered1;
        qcPairContact& pair = *m_pairs.Find(a.owner, b.owner);
        pair.isDue = !Holds(pair, a, b) && !AreFar(present, &pair);
        pair.checked = m_number;
        contacts[i] = &pair;
    };
    qcForEach(qcWorkersOf(m_scene.GetSettings().threads), m_present.size(), s_checkBlock, checkPair);
    m_due.clear();
    for (size_t i = 0; i < m_present.size(); i++)
        if (contacts[i]->isDue)
            m_due.push_back(m_present[i]);
    m_pairs.RemoveOld(m_number);
    return m_due.empty();
}

bool qcBatchValidity::IsAsChecked(const btCollisionObject* object) const
{
    const qcBatchObject* gathered = static_cast<const qcBatchScene&>(m_scene).Find(object);
    return gathered != nullptr && gathered->checked == m_number && gathered->state.IsStateOf(object);
}
