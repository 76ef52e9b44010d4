// The rigid objects near soft bodies, as meshes of the soft bodies' scene: qcMeshShapes, and the surfaces of Bullet's
// own shapes. Contacts move them; the scene never tests them against each other.
#ifndef QC_GLUE_SOFT_BODY_SCENE_RIGID_MESHES_H
#define QC_GLUE_SOFT_BODY_SCENE_RIGID_MESHES_H

#include "soft_body/scene/lone_bodies.h"
#include "soft_body/scene/object_starts.h"
#include "soft_body/scene/reshaped_objects.h"
#include "soft_body/scene/rigid_index.h"
#include "soft_body/scene/rigid_overlaps.h"
#include "soft_body/scene/rigid_shapes.h"
#include "soft_body/scene/scene_rigid.h"

#include <memory>
#include <unordered_map>
#include <vector>

class btBroadphaseInterface;

class qcRigidMeshes
{
  public:
    /// The step starts: Bullet has moved nothing yet.
    void BeginStep(const qcBroadphases& broadphases);
    /// Callbacks of the application have run since; Bullet has moved nothing yet.
    void ReadBegin(const qcBroadphases& broadphases)
    {
        m_starts.ReadBegin(broadphases);
    }
    /// See qcObjectStarts.
    qcObjectStarts& Starts()
    {
        return m_starts;
    }
    const qcObjectStarts& Starts() const
    {
        return m_starts;
    }
    /// Calls function(lower, upper) for the motion of each object that Bullet does not move and others respond to,
    /// where the application has moved it or its triangles since the previous step. O(objects * objects near soft
    /// bodies).
    void ForEachPlaced(const qcBroadphases& broadphases, const qcObjectStarts::BoxFunction& function) const;
    /// Reads where all objects start and end the step: see qcObjectStarts. Call it before CollectOverlapping.
    void ReadMotions(const qcBroadphases& broadphases, btScalar timeStep, const qcRigidLimits* limits);
    /// Collects the objects with meshes whose proxies or motions over the step overlap this box, for the next Sync.
    /// `withSurfaces`: also objects without a qcMeshShape.
    void CollectOverlapping(btBroadphaseInterface* broadphase, const btVector3& lower, const btVector3& upper,
                            bool withSurfaces)
    {
        m_overlaps.Collect(m_starts, broadphase, lower, upper, withSurfaces);
    }
    /// The triangles of one of Bullet's own shapes have changed where its revision doesn't show it.
    void InvalidateShape(const btCollisionShape* shape);
    /// An object that is not finite, which the step leaves out, or null.
    const btCollisionObject* NotFinite() const
    {
        return m_starts.NotFinite();
    }
    /// Makes the scene's meshes those of the objects collected since the last call.
    qcStatus Sync(qcScene* scene);
    /// True if there are objects, or parts of surfaces, that are not in the scene.
    bool MayMiss() const;
    /// Adds the meshes of the objects collected since the last call, where they are not in the scene. Sets `added`.
    qcStatus Extend(qcScene* scene, bool* added);
    /// Sets the objects' present transforms in the scene, or those of the start of the step.
    qcStatus SyncTransforms(qcScene* scene, bool atStart = false);
    /// Appends the boxes of the meshes' motions from the start of the step, enlarged by `reach`.
    void AddMotionBoxes(btScalar reach, qcMotionBoxes* boxes) const;
    /// True if each of the objects was in the previous step and starts at its end transform.
    bool StartWhereTheyEnded() const;

    /// Moves objects by the pushes of contacts since the last call. False: there were none.
    bool Commit();
    /// Moves an object from its transform at the start of the step, if it is free.
    void MoveFromStart(qcSceneRigid& rigid, const btTransform& motion);
    /// Changes velocities by the motions of Commit and MoveFromStart since the last call. The step ends here, so far.
    void UpdateVelocities(btScalar timeStep);
    /// Contacts of this step move these objects no further. False: none of them is near a soft body.
    bool Fix(const std::vector<const btCollisionObject*>& objects);
    /// Puts the nodes that are tied to these objects to where they are now.
    void MoveTied(const std::vector<const btCollisionObject*>& objects) const;
    /// Returns the first guided one of these objects that can return, with all its multibody, to the start of the step;
    /// contacts move it no further. False: there is none.
    bool ReturnToStart(const std::vector<qcSceneRigid*>& rigids);
    /// Ends the step, and undoes all motions.
    void Restore();

    /// The present transform of a mesh of the object. False if the object no longer has this mesh, unchanged.
    bool FindTransform(const qcSceneRigid& rigid, const qcSceneMesh& mesh, btTransform* transform) const;
    /// The mesh of a slot and its object, or null.
    const qcSceneMesh* Find(uint32_t slot, qcSceneRigid** rigid);
    /// The number of objects with a surface of one of Bullet's own shapes, or with a qcMeshShape.
    int CountWith(bool surface) const;
    const std::vector<std::unique_ptr<qcSceneRigid>>& Rigids() const
    {
        return m_rigids;
    }

  private:
    bool IsReshaped(const btCollisionObject* object, btVector3 box[2]) const;
    void AddReshaped();
    void KeepReshaped();
    qcSceneRigid* FindLast(const btCollisionObject* object) const;
    std::vector<std::unique_ptr<qcSceneRigid>> TakeTracked();
    void FindMultiBody(qcSceneRigid* rigid);
    qcStatus Track(qcScene* scene, std::unique_ptr<qcSceneRigid> rigid);
    void Index();
    void RecordEnds();

    btScalar m_timeStep = 0;
    qcObjectStarts m_starts;
    qcRigidShapes m_shapes{m_starts};
    qcReshapedObjects m_reshaped;
    qcRigidOverlaps m_overlaps;
    /// Objects whose triangles the application moves, in no scene, at the end of the previous step.
    std::vector<std::unique_ptr<qcSceneRigid>> m_away;
    /// By unique id, in the order in which they were added; then those of Extend.
    std::vector<std::unique_ptr<qcSceneRigid>> m_rigids;
    qcRigidIndex m_rigidIndex, m_awayIndex;
    std::vector<std::pair<qcSceneRigid*, size_t>> m_meshOfSlot;
    std::vector<std::unique_ptr<qcMultiBodyMotion>> m_multibodies;         ///< that have links among the objects
    std::unordered_map<const btMultiBody*, qcJointPositions> m_beginnings; ///< of the step, of all multibodies
};

#endif
