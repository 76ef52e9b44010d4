// Bullet's contacts of nodes with rigid bodies, as limits of positions.
//
// Bullet brings a node out of a rigid body slowly (in the deformable world by m_deformable_erp, 6 % of the depth in a
// step). Without limits, layers of cloth that press on the lowest one would sink with it.
#include "soft_body/response/rigid_node_contacts.h"

#include <algorithm>

namespace
{
void AddNodeContact(qcSceneSoftBody& soft, const btSoftBody::Node* node, const btSoftBody::sCti& contact,
                    std::vector<qcRigidNodeContact>* contacts)
{
    if (!soft.moves || node->m_im <= 0)
        return;
    btVector3* position = &soft.positions[soft.IndexOf(node)];
    contacts->push_back({position, node->m_im, contact.m_colObj, contact.m_normal, contact.m_normal.dot(*position), 0});
}
} // namespace

void qcCollectRigidNodeContacts(qcSoftBodyScene& scene, std::vector<qcRigidNodeContact>* contacts)
{
    contacts->clear();
    for (qcSceneSoftBody& soft : scene.Bodies())
    {
        const btSoftBody& body = *soft.body;
        for (int i = 0; i < body.m_rcontacts.size(); i++)
            AddNodeContact(soft, body.m_rcontacts[i].m_node, body.m_rcontacts[i].m_cti, contacts);
        for (int i = 0; i < body.m_nodeRigidContacts.size(); i++)
            AddNodeContact(soft, body.m_nodeRigidContacts[i].m_node, body.m_nodeRigidContacts[i].m_cti, contacts);
        for (int i = 0; i < body.m_faceRigidContacts.size(); i++)
            for (btSoftBody::Node* node : body.m_faceRigidContacts[i].m_face->m_n)
                AddNodeContact(soft, node, body.m_faceRigidContacts[i].m_cti, contacts);
    }
}

size_t qcPartitionMovedContacts(std::vector<qcRigidNodeContact>* contacts)
{
    auto isMoved = [](const qcRigidNodeContact& contact)
    { return contact.normal.dot(*contact.position) != contact.level; };
    return size_t(std::stable_partition(contacts->begin(), contacts->end(), isMoved) - contacts->begin());
}

void qcSolveRigidNodeContacts(std::vector<qcRigidNodeContact>* contacts, size_t count)
{
    for (size_t i = 0; i < count; i++)
    {
        qcRigidNodeContact& contact = (*contacts)[i];
        btScalar depth = contact.level - contact.normal.dot(*contact.position);
        if (depth <= 0)
            continue;
        *contact.position += contact.normal * depth;
        contact.raised += depth;
    }
}

void qcApplyRigidNodeImpulses(const std::vector<qcRigidNodeContact>& contacts, btScalar timeStep)
{
    for (const qcRigidNodeContact& contact : contacts)
    {
        auto* body = const_cast<btRigidBody*>(btRigidBody::upcast(contact.object));
        if (body == nullptr || contact.raised == 0 || body->isStaticOrKinematicObject())
            continue;
        btVector3 impulse = contact.normal * (-contact.raised / (contact.inverseMass * timeStep));
        body->applyImpulse(impulse, *contact.position - body->getCenterOfMassPosition());
    }
}
