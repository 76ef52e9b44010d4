// Contact response by projection: moves nodes of soft bodies, and meshes, apart along contacts.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_POSITION_CONSTRAINTS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_POSITION_CONSTRAINTS_H

#include "soft_body/response/rigid_node_contacts.h"
#include "soft_body/response/rope_links.h"
#include "soft_body/response/tangles.h"

#include <algorithm>

/// The share of a gap missing at the start of the step that one step restores.
constexpr btScalar qcGapRecovery = btScalar(0.2);

/// Likewise where positions become velocities: in shorter steps than 1/60 s less, so that surfaces are not thrown apart
/// the faster, the shorter the step.
inline btScalar qcGapRecoveryOf(btScalar timeStep)
{
    return std::min(qcGapRecovery, btScalar(12.5) * timeStep);
}

/// A contact of the result with its bodies. Side A is a soft body; side B another one, the same one, or a mesh.
struct qcSoftContactView
{
    qcSceneSoftBody *a = nullptr, *b = nullptr; ///< b: null for a mesh
    qcSceneRigid* rigid = nullptr;              ///< null for a soft body b
    const qcSceneMesh* mesh = nullptr;          ///< of the rigid object
    const uint32_t *verticesA, *verticesB;
    const double *weightsA, *weightsB;
    btVector3 normal; ///< towards A
    btVector3 onA, onB;
    btScalar distance;  ///< between the triangles
    btScalar thickness; ///< contact distance: closer than this they push each other
    btScalar friction;
};

/// Fills the view. False for a contact without response: further apart than the thickness, or filtered out by Bullet.
bool qcViewContact(qcSoftBodyScene& scene, const qcContact& contact, qcSoftContactView* view);

/// A contact as a constraint on the positions of up to six nodes, or of three and a point of a mesh:
/// normal . (sum of weight * position - point) >= distance.
struct qcSoftConstraint
{
    int nodeCount = 0;
    btVector3* position[6];            ///< of its nodes
    btScalar inverseMass[6];           ///< 0: fixed, or of a body that does not move
    btScalar weight[6];                ///< positive on the side to which the normal points, negative on the other
    btScalar inverseEffectiveMass = 0; ///< of the nodes: sum of weight^2 * inverse mass
    qcSceneRigid* rigid = nullptr;     ///< the mesh's object, or null
    btVector3 place;                   ///< on the mesh, in the frame of its object
    btVector3 point, arm;              ///< there at the last Commit; the arm is from the object's centre to the point
    btVector3 normal;
    btVector3 startOffset{0, 0, 0}; ///< the weighted sum at the start of the step
    btVector3 conveyed{0, 0, 0};    ///< motion of the mesh's surface in the step: see qcSceneRigid::ConveyedAt
    btScalar distance = 0;
    btScalar missing = 0;   ///< of the thickness, at the start of the step; a part of it is to be restored
    bool isTangled = false; ///< its two bodies are
    btScalar thickness = 0; ///< contact distance; `distance` is less where a gap is restored over several steps
    btScalar friction = 0;
    /// For ropes: friction and normal push are bounded as sums over all sweeps, so that friction takes back what links,
    /// solved in alternation, pull loose. Otherwise they are bounded in each sweep by itself.
    bool accumulates = false;
    btScalar pushed = 0;      ///< along the normal so far
    btVector3 taken{0, 0, 0}; ///< sliding that friction has taken back so far
    /// Friction by the load of force chains through this contact: an impulse times the time step.
    btScalar chainFriction = 0;
    bool isInChain = false;  ///< of force chains
    bool isTied = false;     ///< one of its nodes moves with a rigid body
    qcSceneRigid* tiedTo[6]; ///< the body that moves with the node, which then has no inverse mass; or null
};

class qcForceChains;

/// The offset from the negative side to the positive one at present: the weighted sum of its points.
btVector3 qcOffsetOf(const qcSoftConstraint& constraint);

/// True if contacts between the bodies of these two slots (or of one with itself) push them apart.
bool qcHasResponse(qcSoftBodyScene& scene, uint32_t slotA, uint32_t slotB);
/// True if contacts between the triangles of a pair push them apart.
bool qcHasResponse(qcSoftBodyScene& scene, const qcPair& pair);
/// True if contacts between the two bodies push them apart.
bool qcHasResponse(const qcSceneSoftBody& soft, const qcSceneRigid& rigid, const qcSceneMesh& mesh);
/// True if contacts of a soft body with some surface of the object push them apart.
bool qcHasResponse(const qcSceneSoftBody& soft, const btCollisionObject* object);

/// A point of a mesh in the frame of its object: where it is, and where the mesh had it at the start of the step.
struct qcMeshPlace
{
    btVector3 point, start;
};

/// Makes a constraint between a soft body and a point of a mesh. False: nothing can move.
bool qcMakeMeshConstraint(qcSceneSoftBody& soft, const uint32_t vertices[3], const double weights[3],
                          qcSceneRigid& rigid, const qcMeshPlace& place, const btVector3& normal, btScalar thickness,
                          qcSoftConstraint* constraint);

/// Makes a constraint for each contact of the result that has a response and is not exempt. `contactOf` receives the
/// contact's index in the result for each.
void qcMakeSoftConstraints(qcSoftBodyScene& scene, const qcSoftTangles& tangles, const qcResult& result,
                           std::vector<qcSoftConstraint>* constraints, std::vector<size_t>* contactOf);

/// Gauss-Seidel sweeps over the links, the chains, the constraints in their order, and the rigid node contacts. Meshes
/// move with the next Commit.
void qcSolveSoftConstraints(std::vector<qcSoftConstraint>* constraints, qcForceChains* chains, const qcRopeLinks& links,
                            std::vector<qcRigidNodeContact>* rigidNodeContacts, int iterations);

/// Likewise, as a motion without velocity: see qcSceneSoftBody::shifts and qcSceneRigid::recovered. Only what pushes
/// multibodies gives velocities.
void qcSolveWithoutVelocity(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints, qcForceChains* chains,
                            const qcRopeLinks& links, std::vector<qcRigidNodeContact>* rigidNodeContacts,
                            int iterations);

/// Has the constraints restore this share of the gaps that were missing at the start of the step, with the velocity
/// that it gives; `onlyTangled`: those of tangled bodies, which come apart by it.
void qcAddRecovery(std::vector<qcSoftConstraint>* constraints, btScalar share, bool onlyTangled);

/// Restores gaps that were missing at the start of the step after the sweeps, in further ones, without velocity.
void qcRestoreGaps(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints, qcForceChains* chains,
                   std::vector<qcRigidNodeContact>* rigidNodeContacts, btScalar share, int iterations);

#endif
