// Moves nodes of soft bodies, and meshes, apart along contacts.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_POSITION_CONSTRAINTS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_POSITION_CONSTRAINTS_H

#include "soft_body/response/rope_links.h"
#include "soft_body/response/node_supports.h"
#include "soft_body/response/tangles.h"

/// A contact of the result, as the response sees it: side A is a soft body, side B another one, itself, or a mesh.
struct qcSoftTouch
{
    qcSceneSoftBody *a = nullptr, *b = nullptr; ///< b: null for a mesh
    qcSceneRigid* rigid = nullptr;              ///< and this then is not
    const uint32_t *verticesA, *verticesB;
    const double *weightsA, *weightsB;
    btVector3 normal; ///< towards A
    btVector3 onA, onB;
    btScalar distance;  ///< between the triangles
    btScalar thickness; ///< at which they push
    btScalar friction;
};

/// False for a contact that does not push: further apart than the thickness, or filtered by Bullet.
bool qcReadTouch(qcSoftBodyScene& scene, const qcContact& contact, qcSoftTouch* touch);

/// A contact as a constraint on the places of up to six nodes, or three and a mesh: normal . (sum of weight * place) >=
/// distance, the point of the mesh taken off the sum.
struct qcSoftConstraint
{
    int nodeCount = 0;
    btVector3* place[6];               ///< of its nodes
    btScalar inverseMass[6];           ///< 0: pinned, or of a body that does not move
    btScalar weight[6];                ///< positive on the side to which the normal points, negative on the other
    btScalar inverseEffectiveMass = 0; ///< sum of weight^2 * inverse mass
    qcSceneRigid* rigid = nullptr;     ///< the mesh's, or null
    btVector3 point, arm;              ///< of the mesh, and from the rigid body's centre there
    btVector3 normal;
    btVector3 startOffset{0, 0, 0}; ///< the same weighted sum over the start of the step
    btScalar distance = 0;
    btScalar friction = 0;
    /// Contacts of ropes: friction and normal push are bounded as sums over all sweeps, so that friction takes back
    /// what links, solved in turns with it, pull loose. Otherwise each sweep by itself.
    bool accumulates = false;
    btScalar pushed = 0;      ///< along the normal so far
    btVector3 taken{0, 0, 0}; ///< of the sliding so far
};

/// May contacts between the bodies of these two slots (or of one with itself) push?
bool qcMayPush(qcSoftBodyScene& scene, uint32_t slotA, uint32_t slotB);
bool qcMayPush(const qcSceneSoftBody& soft, const qcSceneRigid& rigid);

/// A constraint between a soft body and a mesh's point, which is given in the object's frame. False: nothing can move.
bool qcMakeMeshConstraint(qcSceneSoftBody& soft, const uint32_t vertices[3], const double weights[3],
                          qcSceneRigid& rigid, const btVector3& point, const btVector3& normal, btScalar thickness,
                          qcSoftConstraint* constraint);

/// One constraint for each contact of the result within its bodies' thickness, tangled ones left out; `contactOf`
/// receives for each the contact's index in the result.
void qcMakeSoftConstraints(qcSoftBodyScene& scene, const qcSoftTangles& tangles, const qcResult& result,
                           std::vector<qcSoftConstraint>* constraints, std::vector<size_t>* contactOf);

/// One constraint for each node that went through a mesh in the step, and further than contacts reach: it is kept on
/// the side of the triangle that it went through first.
void qcMakeSweptConstraints(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints);
/// Appends one for each rope link that crossed an edge of a mesh between the start of the step and its present place:
/// it is kept on the side of the first such edge on which it was.
void qcAddSweptLinks(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints);

/// Gauss-Seidel over the links, the constraints, in their order, and the supports, some times. Meshes move with the
/// next Commit.
void qcSolveSoftConstraints(std::vector<qcSoftConstraint>* constraints, const std::vector<qcSoftLink>& links,
                            std::vector<qcSoftSupport>* supports, int iterations);

#endif
