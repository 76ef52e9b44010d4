// The objects of a world that hold meshes, and its convex shapes that may pass one, with their motion in a step, and
// the pairs whose motions overlap.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_OBJECTS_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_OBJECTS_H

#include "common/changed_shapes.h"
#include "common/rigid_limits.h"
#include "mesh_contact/limits/common_shift.h"
#include "mesh_contact/limits/contact_depths.h"
#include "mesh_contact/limits/moving_meshes.h"
#include "mesh_contact/limits/resting_meshes.h"
#include "mesh_contact/limits/swept_multibodies.h"
#include "mesh_contact/limits/swept_object.h"
#include "mesh_contact/limits/swept_starts.h"
#include "mesh_contact/planes/axis_cache.h"

#include <memory>

class qcSweptObjects
{
  public:
    qcSweptObjects(const qcBatchSettings& settings, qcAxisCache& axes)
        : m_settings(settings), m_axes(axes), m_multibodies(settings)
    {
    }

    /// Keeps the triangles of an object that Bullet does not move, since the application may move them.
    void KeepTriangles(const btCollisionObject* object);
    /// Call it after the triangles of a shape have changed.
    void InvalidateShape(const btCollisionShape* shape);
    /// Dynamic objects start the step here. Without this call within the step, starts follow from velocities.
    void MarkStarts();
    /// Finds the starts of the step that ends now, then does what ReadTargets does.
    bool ReadMotions(btScalar timeStep, qcScene* scene);
    /// Reads the present transforms as the targets. Meshes of objects that left the world, or are not finite, are
    /// removed from the scene.
    /// True if an object has moved.
    bool ReadTargets(const qcStartFunction& startOf, qcScene* scene);
    /// Makes an object, and all links of its multibody, stay where they are until targets are read again. A mesh that
    /// the application moves through one is an unproven pair.
    void Hold(const btCollisionObject* object);
    /// The pairs that collide and whose boxes overlap; at least one of the two moves, and one is not isUnmoved. Static
    /// meshes that were left out take part from here on if something moves near them.
    void FindPairs(qcScene* scene, std::vector<qcSweptPair>* pairs);
    /// The next step starts at the present transforms. Static meshes without a pair in this one are left out.
    void RecordEnds();
    /// True if all objects in the world that are finite are where RecordEnds has seen them.
    bool AreAtEnds();
    /// True if meshes that limits have moved may pass convex shapes that were too slow to take part. O(objects * such
    /// meshes).
    bool MissesCores();
    /// The entry of an object in the world, or null.
    qcSweptObject* Find(const btCollisionObject* object) const;
    /// Inner cores of an object take part, too, if it has cores.
    void AddInnerCores(qcSweptObject* swept);

    /// An object that may hold meshes and is not finite, which the last ReadTargets has left out, or null.
    const btCollisionObject* NotFinite() const
    {
        return m_notFinite;
    }
    /// The world's multibodies with links among the objects.
    qcSweptMultiBodies& MultiBodies()
    {
        return m_multibodies;
    }
    /// All objects but static meshes that are left out.
    const std::vector<qcSweptObject*>& Get() const
    {
        return m_sorted;
    }

  private:
    void StartWherePut();
    qcSweptObject* Add(const btCollisionObject* object);
    void ReadTriangles(qcSweptObject* swept, qcScene* scene) const;
    void EndDeformations() const;
    void RemoveGone(qcScene* scene);
    btScalar TravelNear(const btCollisionObject* object) const;
    bool MayPass(const btCollisionObject* object, btScalar halfWidth) const;
    bool TakesCores(const btCollisionObject* object);
    qcSweptObject& ReadTarget(btCollisionObject* object, bool takesCores, qcScene* scene);
    bool ReadObjects(bool readsDepths, qcScene* scene);
    void WakeNearMoving(qcScene* scene);
    void LetRest();

    const qcBatchSettings& m_settings;
    qcAxisCache& m_axes;
    qcConvexCores m_cores{qcCoreSize}, m_innerCores{qcInnerCoreSize};
    qcContactDepths m_depths;
    qcBodyOrigins m_origins;
    btScalar m_timeStep = 0;
    qcMovingMeshes m_movingMeshes; ///< those whose contact is computed here
    const btCollisionObject* m_notFinite = nullptr;
    size_t m_coreCount = 0;     ///< objects whose convex shapes are swept
    bool m_anyOurs = false;     ///< there is an object whose contact is computed here
    bool m_anyFreeMesh = false; ///< there is one that is no static or kinematic body
    std::unordered_map<qcObjectKey, std::unique_ptr<qcSweptObject>, qcObjectKeyHash> m_objects;
    std::vector<qcSweptObject*> m_sorted;
    qcRestingMeshes m_resting; ///< what m_sorted lacks of the objects
    qcSweptStarts m_starts;
    qcSweptMultiBodies m_multibodies;
    qcChangedShapes m_changedShapes; ///< since objects were read
    qcStaticPlanes m_planes;
    qcIdCounter m_numbers;
    uint64_t m_step = 0;
    bool m_findsStarts = false; ///< while motions are read: starts are not marked
};

#endif
