// Nodes that lie on rigid bodies.
//
// Bullet brings a node out of a rigid body slowly (in the deformable world by m_deformable_erp, 6 % of the depth in a
// step), so layers of cloth that press down on the lowest one would sink with it.
#include "soft_body/response/node_supports.h"

#include <algorithm>

namespace
{
void Add(qcSceneSoftBody& soft, const btSoftBody::Node* node, const btSoftBody::sCti& contact,
         std::vector<qcSoftSupport>* supports)
{
    if (!soft.moves || node->m_im <= 0)
        return;
    btVector3* place = &soft.places[soft.NumberOf(node)];
    supports->push_back({place, node->m_im, contact.m_colObj, contact.m_normal, contact.m_normal.dot(*place), 0});
}
} // namespace

void qcCollectSupports(qcSoftBodyScene& scene, std::vector<qcSoftSupport>* supports)
{
    supports->clear();
    for (qcSceneSoftBody& soft : scene.Bodies())
    {
        const btSoftBody& body = *soft.body;
        for (int i = 0; i < body.m_rcontacts.size(); i++)
            Add(soft, body.m_rcontacts[i].m_node, body.m_rcontacts[i].m_cti, supports);
        for (int i = 0; i < body.m_nodeRigidContacts.size(); i++)
            Add(soft, body.m_nodeRigidContacts[i].m_node, body.m_nodeRigidContacts[i].m_cti, supports);
        for (int i = 0; i < body.m_faceRigidContacts.size(); i++)
            for (btSoftBody::Node* node : body.m_faceRigidContacts[i].m_face->m_n)
                Add(soft, node, body.m_faceRigidContacts[i].m_cti, supports);
    }
}

size_t qcMovedSupports(std::vector<qcSoftSupport>* supports)
{
    auto isMoved = [](const qcSoftSupport& support) { return support.normal.dot(*support.place) != support.level; };
    return size_t(std::stable_partition(supports->begin(), supports->end(), isMoved) - supports->begin());
}

void qcHoldSupports(std::vector<qcSoftSupport>* supports, size_t count)
{
    for (size_t i = 0; i < count; i++)
    {
        qcSoftSupport& support = (*supports)[i];
        btScalar depth = support.level - support.normal.dot(*support.place);
        if (depth <= 0)
            continue;
        *support.place += support.normal * depth;
        support.raised += depth;
    }
}

void qcApplySupports(const std::vector<qcSoftSupport>& supports, btScalar timeStep)
{
    for (const qcSoftSupport& support : supports)
    {
        auto* body = const_cast<btRigidBody*>(btRigidBody::upcast(support.object));
        if (body == nullptr || support.raised == 0 || body->isStaticOrKinematicObject())
            continue;
        btVector3 impulse = support.normal * (-support.raised / (support.inverseMass * timeStep));
        body->applyImpulse(impulse, *support.place - body->getCenterOfMassPosition());
    }
}
