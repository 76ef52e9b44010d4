// Bullet's own contacts of nodes with rigid bodies, as limits: contacts among soft bodies must not press these nodes
// deeper into the rigid body.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_RIGID_NODE_CONTACTS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_RIGID_NODE_CONTACTS_H

#include "soft_body/scene/soft_scene.h"

/// A node in one of Bullet's contacts with a rigid body: normal . position >= level.
struct qcRigidNodeContact
{
    btVector3* position; ///< of the node
    btScalar inverseMass;
    const btCollisionObject* object;
    btVector3 normal; ///< from the rigid body to the node
    btScalar level;   ///< before contacts among soft bodies
    btScalar raised;  ///< sum of the distances by which the limit moved the node
};

void qcCollectRigidNodeContacts(qcSoftBodyScene& scene, std::vector<qcRigidNodeContact>* contacts);

/// Puts the contacts of moved nodes first, and returns their count.
size_t qcPartitionMovedContacts(std::vector<qcRigidNodeContact>* contacts);

/// Raises the nodes of the first `count` contacts to their levels.
void qcSolveRigidNodeContacts(std::vector<qcRigidNodeContact>* contacts, size_t count);

/// Gives the rigid bodies the reactions to what raised the nodes.
void qcApplyRigidNodeImpulses(const std::vector<qcRigidNodeContact>& contacts, btScalar timeStep);

#endif
