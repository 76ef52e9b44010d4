// Contacts of the previous step in Bullet's own solver.
#include "soft_body/response/held_contacts.h"

#include <algorithm>
#include <cmath>

namespace
{
// The rigid point's share of a correction. From its displacement the sum of all corrections is read.
constexpr btScalar s_pointShare = btScalar(0.01);

btScalar SquaredWeights(const qcHeldContact& contact)
{
    btScalar sum = 0;
    for (int i = 0; i < contact.count; i++)
        sum += contact.weights[i] * contact.weights[i];
    return sum;
}

/// True if the application has moved one of the contact's nodes since: Bullet would take that for a velocity.
bool IsApplied(const qcSceneSoftBody& soft, const qcHeldContact& contact)
{
    return std::any_of(contact.nodes, contact.nodes + contact.count,
                       [&soft](uint32_t node) { return soft.IsApplied(node); });
}

btVector3 StartOf(const qcSceneSoftBody& soft, const qcHeldContact& contact)
{
    btVector3 sum(0, 0, 0);
    for (int i = 0; i < contact.count; i++)
        sum += soft.start[contact.nodes[i]] * contact.weights[i];
    return sum;
}

/// Where Bullet has the soft side now.
btVector3 PresentOf(const qcSceneSoftBody& soft, const qcHeldContact& contact)
{
    btVector3 sum(0, 0, 0);
    for (int i = 0; i < contact.count; i++)
        sum += soft.body->m_nodes[int(contact.nodes[i])].m_x * contact.weights[i];
    return sum;
}

/// Fills Bullet's contact of a face with a node, whose normal is towards the node.
void Fill(const qcSceneSoftBody& soft, const qcHeldContact& held, const btVector3& normal, btScalar distance,
          btSoftBody::Node* node, btSoftBody::Face* face, btSoftBody::SContact* contact)
{
    contact->m_weights.setZero();
    for (int i = 0; i < 3; i++)
    {
        int used = std::min(i, held.count - 1);
        face->m_n[i] = &soft.body->m_nodes[int(held.nodes[used])];
        contact->m_weights[i] = i < held.count ? held.weights[i] : btScalar(0);
    }
    contact->m_node = node;
    contact->m_face = face;
    contact->m_normal = -normal;
    contact->m_margin = distance;
    contact->m_friction = 0;
    contact->m_cfm[0] = s_pointShare;
    contact->m_cfm[1] = 1 / SquaredWeights(held);
}

/// True if a contact of the previous step holds at its gap at the start of this one.
bool MayHold(btScalar gap, btScalar thickness)
{
    return gap > 0 && gap <= thickness * btScalar(1.1);
}
} // namespace

qcHeldPoint qcHeldPointOf(const qcSoftConstraint& constraint)
{
    const btTransform& now = constraint.rigid->object->getWorldTransform();
    return {qcObjectKey(constraint.rigid->object), now * constraint.place - constraint.conveyed, constraint.place,
            now.getBasis().transpose() * constraint.normal};
}

void qcHeldContacts::Keep(qcSoftBodyScene& scene, const qcSoftTangles& tangles,
                          const std::vector<qcSoftConstraint>& constraints)
{
    for (qcSceneSoftBody& soft : scene.Bodies())
        soft.heldContacts.clear();
    for (const qcSoftConstraint& constraint : constraints)
    {
        // Ropes solve links and contacts in turns; what contacts move has to take its share.
        if (constraint.rigid == nullptr || constraint.rigid->CanMove() || constraint.accumulates)
            continue;
        qcHeldContact held;
        qcSceneSoftBody* soft = nullptr;
        bool isFree = true;
        for (int i = 0; i < constraint.nodeCount; i++)
        {
            soft = scene.OwnerOf(constraint.position[i], &held.nodes[i]);
            held.weights[i] = constraint.weight[i];
            // Bullet would move pinned nodes, too.
            isFree = isFree && constraint.inverseMass[i] > 0;
        }
        if (soft == nullptr || !isFree || tangles.AreTangled(*soft, *constraint.rigid))
            continue;
        held.count = constraint.nodeCount;
        held.rigid = qcHeldPointOf(constraint);
        held.thickness = constraint.thickness;
        held.friction = constraint.friction;
        soft->heldContacts.push_back(held);
    }
}

/// The distance at which a contact holds. Bullet moves an approaching side to it, also from further away: a pull that
/// contact would push back, with friction. So it holds no nearer than the side gets by itself.
btScalar qcHeldContacts::DistanceOf(const Inserted& inserted)
{
    const qcSceneSoftBody& soft = *inserted.soft;
    const qcHeldContact& contact = *inserted.contact;
    const btScalar gap = inserted.normal.dot(StartOf(soft, contact) - inserted.start);
    const btScalar held = qcHeldShare * contact.thickness;
    if (gap < held)
        return gap + qcGapRecoveryOf(soft.body->m_sst.sdt) * (held - gap);
    return btClamped(inserted.normal.dot(PresentOf(soft, contact) - inserted.end), held, gap);
}

void qcHeldContacts::Insert(qcSoftBodyScene& scene, qcPresentObjects* present)
{
    m_inserted.clear();
    m_counts.clear();
    for (qcSceneSoftBody& soft : scene.Bodies())
    {
        m_counts.push_back(soft.body->m_scontacts.size());
        if (!soft.moves)
            continue;
        for (const qcHeldContact& held : soft.heldContacts)
        {
            if (IsApplied(soft, held) || !present->Contains(soft, held.rigid.object))
                continue;
            Inserted inserted = {&soft, &held, held.rigid.Normal(), held.rigid.point, held.rigid.Point()};
            btScalar gap = inserted.normal.dot(StartOf(soft, held) - held.rigid.point);
            // An object that is not finite holds nothing.
            if (MayHold(gap, held.thickness) && std::isfinite(inserted.end.length2()))
                m_inserted.push_back(inserted);
        }
    }
    m_nodes.assign(m_inserted.size(), btSoftBody::Node());
    m_faces.assign(m_inserted.size(), btSoftBody::Face());
    for (size_t i = 0; i < m_inserted.size(); i++)
    {
        const Inserted& inserted = m_inserted[i];
        m_nodes[i].m_q = inserted.start;
        m_nodes[i].m_x = inserted.end;
        btSoftBody::SContact contact;
        Fill(*inserted.soft, *inserted.contact, inserted.normal, DistanceOf(inserted), &m_nodes[i], &m_faces[i],
             &contact);
        inserted.soft->body->m_scontacts.push_back(contact);
    }
}

void qcHeldContacts::Remove(qcSoftBodyScene& scene)
{
    for (size_t i = 0; i < m_counts.size(); i++)
        scene.Bodies()[i].body->m_scontacts.resize(m_counts[i]);
    for (size_t i = 0; i < m_inserted.size(); i++)
    {
        const Inserted& inserted = m_inserted[i];
        const qcHeldContact& held = *inserted.contact;
        btSoftBody& body = *inserted.soft->body;
        // Coulomb friction takes back sliding, at most the normal push times the coefficient.
        btScalar pushed = inserted.normal.dot(inserted.end - m_nodes[i].m_x) / s_pointShare;
        const btVector3 motion =
            inserted.start - inserted.end - StartOf(*inserted.soft, held) + PresentOf(*inserted.soft, held);
        btVector3 sliding = motion - inserted.normal * inserted.normal.dot(motion);
        btScalar length = sliding.length(), largest = held.friction * std::max(btScalar(0), pushed);
        if (length <= SIMD_EPSILON)
            continue;
        sliding *= std::min(btScalar(1), largest / length) / SquaredWeights(held);
        for (int k = 0; k < held.count; k++)
        {
            btSoftBody::Node& node = body.m_nodes[int(held.nodes[k])];
            node.m_x -= sliding * held.weights[k];
            node.m_v -= sliding * held.weights[k] * (body.m_sst.isdt * (1 - body.m_cfg.kDP));
        }
    }
}
