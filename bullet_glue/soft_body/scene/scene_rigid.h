// A rigid object near soft bodies: its meshes, where it starts the step, and how contacts move it.
#ifndef QC_GLUE_SOFT_BODY_SCENE_SCENE_RIGID_H
#define QC_GLUE_SOFT_BODY_SCENE_SCENE_RIGID_H

#include "common/multibody_motion.h"
#include "soft_body/scene/scene_mesh.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <vector>

struct qcSceneSoftBody;

/// A node that is anchored to a rigid body and moves with it in contact.
struct qcTiedNode
{
    qcSceneSoftBody* soft;
    uint32_t node;
    btVector3 local; ///< where it is, in the frame of the body
};

/// An object with meshes.
struct qcSceneRigid
{
    btCollisionObject* object = nullptr;
    int uniqueId = 0;          ///< see qcUniqueIdOf
    bool withSurfaces = false; ///< `shapes` are not only qcMeshShapes
    bool isReshaped = false;   ///< other triangles than in the previous step, and no mesh of it deforms
    std::vector<qcSceneShape> shapes;
    std::vector<qcSceneMesh> meshes; ///< one for each shape that has triangles
    qcActivity activity = qc_activityMoving;
    btRigidBody* body = nullptr;                     ///< null: contacts move no rigid body
    qcMultiBodyMotion* multibody = nullptr;          ///< null: contacts move no link of a multibody
    size_t link = 0;                                 ///< its index there
    btTransform start = btTransform::getIdentity();  ///< of the object, at the start of the step
    btTransform solved = btTransform::getIdentity(); ///< of the object, after Bullet's own solvers

    /// Displacement of its surface in the step, if it stays in place and has velocities: a conveyor belt.
    qcRigidDisplacement conveyed;

    bool isGuided = false;         ///< it can move, and not in all directions alike: joints or factors guide it
    qcRigidDisplacement pushed;    ///< of its body, by contacts since the last Commit
    qcRigidDisplacement moved;     ///< of its body, by Commit since the last UpdateVelocities
    qcRigidDisplacement recovered; ///< the part of `moved` that gives no velocity
    bool isFixed = false; ///< contacts of this step move it no further: its limits have stopped it, or it has returned
    bool fromStart = false;       ///< a zone moves it from the start of the step, which determines its velocity, too
    bool hasEnd = false;          ///< the object was in the previous step
    std::vector<qcTiedNode> tied; ///< nodes that move with its body
    btScalar massShare = 1;       ///< of its body's mass in that of the body with these nodes
    int stepsInPlace = 0;         ///< for how long the object has not moved, up to what a conveyor belt needs
    btTransform end = btTransform::getIdentity(); ///< of the object, at the end of the previous step

    /// True if contacts can move the object, unless it is fixed.
    bool CanMove() const
    {
        return body != nullptr || multibody != nullptr;
    }
    /// Displacement of the point at `arm` from the centre, if `push` acts there: an impulse times the time step.
    btVector3 DisplacementAt(const btVector3& arm, const btVector3& push) const;
    /// Likewise, of the object.
    qcRigidDisplacement DisplacementBy(const btVector3& arm, const btVector3& push) const;
    /// Adds the motion by this push: of the object, or of all links of its multibody.
    void Push(const btVector3& arm, const btVector3& push);
    /// Adds a motion that gives its body no velocity.
    void MoveWithoutVelocity(const qcRigidDisplacement& by)
    {
        BeginRecovery();
        pushed.linear += by.linear;
        pushed.angular += by.angular;
        EndRecovery();
    }
    /// Has a node move with the body from here on, as it lies now.
    void Tie(qcSceneSoftBody* soft, uint32_t node);
    /// Puts the tied nodes to where the body is, with what contacts have pushed it by.
    void MoveTied() const;
    /// Pushes from here to EndRecovery give its body no velocity.
    void BeginRecovery()
    {
        recovered.linear -= pushed.linear;
        recovered.angular -= pushed.angular;
    }
    void EndRecovery()
    {
        recovered.linear += pushed.linear;
        recovered.angular += pushed.angular;
    }
    /// Displacement by the pushes since the last Commit.
    const qcRigidDisplacement& Pushed() const
    {
        return multibody != nullptr ? multibody->Displacement(link) : pushed;
    }
    /// The motion of its surface in the step, as that of a conveyor belt, without what is along the normal.
    btVector3 ConveyedAt(const btVector3& point, const btVector3& normal) const
    {
        const btVector3 motion = conveyed.At(point - object->getWorldTransform().getOrigin());
        return motion - normal * normal.dot(motion);
    }
    /// Wakes it, and its multibody, if Bullet moves it and it sleeps.
    void Wake() const;
    /// True if it can take any rigid motion: it is dynamic, and no factor or infinite inertia restricts it.
    bool IsFree() const;
    /// Marks what was read of one of Bullet's own shapes as stale.
    void Invalidate(const btCollisionShape* shape);
    /// Has meshes deform from those of the previous step: see qcSceneMesh::DeformFrom.
    void DeformFrom(const qcSceneRigid& last);
    /// See qcSceneMesh.
    void TakeBodies(qcSceneRigid* last);
    /// See qcSceneMesh::Rest; true if none of its meshes deforms.
    bool Rest();
    /// True if one of its meshes deforms in the step.
    bool Deforms() const
    {
        return std::any_of(meshes.begin(), meshes.end(), [](const qcSceneMesh& mesh) { return mesh.Deforms(); });
    }
    /// A vertex of one of its meshes at the start of the step, in world space.
    btVector3 StartOf(const qcSceneMesh& mesh, uint32_t vertex) const
    {
        return start * (mesh.local * mesh.StartVertex(vertex));
    }
    /// Likewise at present.
    btVector3 PresentOf(const qcSceneMesh& mesh, uint32_t vertex) const
    {
        return object->getWorldTransform() * (mesh.local * mesh.shape->getVertices()[vertex]);
    }
    /// The motion from the start of the step to another transform; the identity, exactly, if these are equal.
    btTransform MotionTo(const btTransform& transform) const;
    /// The box of the motion of one of its meshes, from the start of the step to the present.
    void FindMotionBox(const qcSceneMesh& mesh, btVector3 box[2]) const;
};

#endif
