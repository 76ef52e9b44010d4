// Moves nodes of soft bodies apart along contacts, and back to where they started where that does not help.
#ifndef QC_BULLET_GLUE_SOFT_BODY_RESPONSE_H
#define QC_BULLET_GLUE_SOFT_BODY_RESPONSE_H

#include "soft_body_scene.h"

/// A contact as a constraint on up to six nodes: normal . (sum of weight * node) >= distance.
struct qcSoftConstraint
{
    int nodeCount;
    btSoftBody::Node* node[6];
    btScalar inverseMass[6]; ///< 0: pinned, or of a body that does not move
    btScalar weight[6];      ///< positive on the side to which the normal points, negative on the other; sums to 0
    btScalar inverseEffectiveMass; ///< sum of weight^2 * inverse mass; 0: nothing can move
    btVector3 normal;
    btVector3 startOffset; ///< the same weighted sum over the start of the step
    btScalar distance;
    btScalar friction;
};

/// May contacts between these two bodies (or of one with itself) push?
bool qcMayPush(const qcSceneSoftBody& a, const qcSceneSoftBody& b);

/// One constraint for each contact of the result within its bodies' thickness; `contactOf` receives for each the
/// contact's index in the result.
void qcMakeSoftConstraints(qcSoftBodyScene& scene, const qcResult& result, std::vector<qcSoftConstraint>* constraints,
                           std::vector<size_t>* contactOf);

/// Gauss-Seidel over the constraints, in their order, some times.
void qcSolveSoftConstraints(const std::vector<qcSoftConstraint>& constraints, int iterations);

/// Puts the nodes of penetrating pairs back to the start of the step, unless the pair penetrated there already.
/// `wholeBodies`: all nodes of their bodies. Returns the number of nodes moved.
int qcFreezePenetrating(qcSoftBodyScene& scene, const qcResult& result, bool wholeBodies);

/// The velocity that leads from the start of the step to the present position, as btSoftBody::solveConstraints sets it,
/// for every node that is not where Bullet's own constraints left it.
void qcUpdateVelocities(qcSoftBodyScene& scene, const std::vector<std::vector<btVector3>>& solved);

#endif
