// Links of ropes in contact, solved again between the sweeps of contact response.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_ROPE_LINKS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_ROPE_LINKS_H

#include "soft_body/scene/soft_scene.h"

/// A link as a constraint on the positions of its two nodes.
struct qcSoftLink
{
    btVector3* position[2];
    btScalar inverseMass[2];
    btScalar restLength2;
    btScalar divisor; ///< sum of the inverse masses, divided by the link's stiffness
};

/// Collects the links with an end that belongs to no face, of moving bodies in contact.
void qcCollectLinks(qcSoftBodyScene& scene, std::vector<qcSoftLink>* links);
/// One Gauss-Seidel sweep, by the formula of btSoftBody::PSolve_Links.
void qcSolveLinks(const std::vector<qcSoftLink>& links);

#endif
