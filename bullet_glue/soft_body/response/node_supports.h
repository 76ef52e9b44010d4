// Nodes that lie on rigid bodies: contacts among soft bodies must not press them into what Bullet keeps them off.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_NODE_SUPPORTS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_NODE_SUPPORTS_H

#include "soft_body/scene/soft_scene.h"

/// A node that is in one of Bullet's contacts with a rigid body. In this step it goes no deeper than it is.
struct qcSoftSupport
{
    btVector3* place; ///< of the node
    btScalar inverseMass;
    const btCollisionObject* object;
    btVector3 normal; ///< from the rigid body to the node
    btScalar level;   ///< normal . place >= level
    btScalar raised;  ///< sum of what it took to hold that
};

void qcCollectSupports(qcSoftBodyScene& scene, std::vector<qcSoftSupport>* supports);

/// Puts the supports first whose nodes were moved, and returns how many these are.
size_t qcMovedSupports(std::vector<qcSoftSupport>* supports);

/// Raises the nodes of the first `count` supports to their levels.
void qcHoldSupports(std::vector<qcSoftSupport>* supports, size_t count);

/// Gives the rigid bodies the impulses with which they held nodes up.
void qcApplySupports(const std::vector<qcSoftSupport>& supports, btScalar timeStep);

#endif
