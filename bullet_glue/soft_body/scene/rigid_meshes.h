// Meshes near soft bodies, as rigid bodies of the soft bodies' scene: pushed by their contacts, and never tested among
// each other there.
#ifndef QC_GLUE_SOFT_BODY_SCENE_RIGID_MESHES_H
#define QC_GLUE_SOFT_BODY_SCENE_RIGID_MESHES_H

#include "quickcullide/bullet_mesh.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <memory>
#include <vector>

class btBroadphaseInterface;

/// Filter groups of the scene: soft bodies meet each other and meshes, meshes meet soft bodies only.
constexpr uint32_t qcSoftGroup = 1, qcMeshGroup = 2;

/// A qcMeshShape of an object. A compound may have several.
struct qcSceneMesh
{
    const qcMeshShape* shape = nullptr;
    btTransform local = btTransform::getIdentity(); ///< of the shape in the object
    uint64_t revision = 0;
    qcBodyId id{};
    btTransform placed = btTransform::getIdentity(); ///< where the scene has it
};

/// An object with meshes. The same address may be another object later: what the broadphase numbers anew when an object
/// is added tells them apart.
struct qcSceneRigid
{
    btCollisionObject* object = nullptr;
    int uniqueId = 0; ///< unique id of its broadphase proxy
    std::vector<qcSceneMesh> meshes;
    qcActivity activity = qc_activityMoving;
    btRigidBody* body = nullptr;                     ///< null: nothing that a contact could move
    btTransform start = btTransform::getIdentity();  ///< of the object, at the start of the step
    btTransform solved = btTransform::getIdentity(); ///< where the world left it

    //  Pushes since the last Commit, of the centre and around it.
    btVector3 linear{0, 0, 0}, angular{0, 0, 0};
    //  All pushes of the step.
    btVector3 movedLinear{0, 0, 0}, movedAngular{0, 0, 0};
    bool fromStart = false;                       ///< moved anew from the start of the step: its velocity is anew, too
    bool ended = false;                           ///< it was there in the step before, and
    btTransform end = btTransform::getIdentity(); ///< this is where that step left it

    /// How a push at a point, `arm` away from the centre, moves that point.
    btVector3 Yield(const btVector3& arm, const btVector3& push) const;
    void Push(const btVector3& arm, const btVector3& push);
    /// False: something keeps it from moving as its zone does.
    bool IsFree() const;
    /// The motion from the start of the step to another transform; the identity, exactly, if these are equal.
    btTransform MotionTo(const btTransform& transform) const;
};

/// How far a point of the mesh moves at most from one transform of the mesh to another.
btScalar qcMotionOf(const qcSceneMesh& mesh, const btTransform& from, const btTransform& to);

/// Where a mesh of the object lies now; false if the object no longer has it as it was.
bool qcFindPlace(const qcSceneRigid& rigid, const qcSceneMesh& mesh, btTransform* place);

/// Where a vertex is in world space, as the scene computes it, if the mesh has this transform.
void qcPlaceVertex(const qcSceneMesh& mesh, const btTransform& transform, uint32_t vertex, double place[3]);

class qcSoftBodyMeshes
{
  public:
    /// Notes the objects with meshes whose boxes meet this one. Boxes of rigid bodies span the motion that Bullet
    /// predicted for the step.
    void Seek(btBroadphaseInterface* broadphase, const btVector3& lower, const btVector3& upper);
    /// Makes the scene's meshes those that were noted since the last call.
    qcStatus Synchronize(qcScene* scene, btScalar timeStep);
    /// Gives the scene the objects' present transforms, or those of the start of the step.
    qcStatus Place(qcScene* scene, bool atStart = false);
    /// True if each of the objects is known since the step before, and starts where that one left it.
    bool StartWhereTheyEnded() const;

    /// Moves objects as contacts pushed them since the last call.
    void Commit();
    /// Moves an object from where it was at the start of the step, if it is free.
    void MoveFromStart(qcSceneRigid& rigid, const btTransform& motion);
    /// Ends the step. Velocities from what Commit and MoveFromStart moved.
    void UpdateVelocities(btScalar timeStep);
    /// Ends the step, and undoes all moves.
    void Restore();

    /// The mesh of a slot and its object, or null.
    const qcSceneMesh* Find(uint32_t slot, qcSceneRigid** rigid);
    const std::vector<std::unique_ptr<qcSceneRigid>>& Rigids() const
    {
        return m_rigids;
    }

  private:
    qcStatus Add(qcScene* scene, qcSceneRigid* rigid);
    void Refresh(qcSceneRigid* rigid, btScalar timeStep);
    void NumberMeshes();
    void NoteEnds();

    std::vector<btCollisionObject*> m_sought;
    std::vector<std::unique_ptr<qcSceneRigid>> m_rigids; ///< in the order in which they came into the world
    std::vector<std::pair<qcSceneRigid*, size_t>> m_meshOfSlot;
};

#endif
