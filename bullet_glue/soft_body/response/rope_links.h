// Links of ropes that touch something, solved again between the sweeps of contact response.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_ROPE_LINKS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_ROPE_LINKS_H

#include "soft_body/scene/soft_scene.h"

/// A link as a constraint on the places of its two nodes.
struct qcSoftLink
{
    btVector3* place[2];
    btScalar inverseMass[2];
    btScalar restLength2;
    btScalar divisor; ///< sum of the inverse masses, divided by the link's stiffness
};

/// Links with an end that no face has, of bodies that move and are in a contact.
void qcCollectLinks(qcSoftBodyScene& scene, std::vector<qcSoftLink>* links);
/// One Gauss-Seidel sweep, as Bullet's own.
void qcSolveLinks(const std::vector<qcSoftLink>& links);

#endif
