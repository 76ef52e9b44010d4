// The objects of a world that hold meshes, and its convex shapes that may pass one, with their motion in a step, and
// the pairs whose motions overlap.
#ifndef QC_GLUE_MESH_CONTACT_SWEPT_OBJECTS_H
#define QC_GLUE_MESH_CONTACT_SWEPT_OBJECTS_H

#include "common/rigid_limits.h"
#include "mesh_contact/axis_cache.h"
#include "mesh_contact/contact_depths.h"
#include "mesh_contact/resting_meshes.h"
#include "mesh_contact/swept_object.h"

#include <memory>

class qcSweptObjects
{
  public:
    qcSweptObjects(const qcBatchSettings& settings, qcAxisCache& axes) : m_settings(settings), m_axes(axes)
    {
    }

    /// Keeps the triangles of an object that Bullet does not move, since the application may move them.
    void KeepTriangles(const btCollisionObject* object);
    /// Call it after the triangles of a shape have changed.
    void InvalidateShape(const btCollisionShape* shape)
    {
        m_changes[shape]++;
        m_resting.WakeAll(&m_sorted);
    }
    /// Dynamic objects start the step here. Without this call within the step, starts follow from velocities.
    void MarkStarts();
    /// Finds the starts of the step that ends now, then does what ReadTargets does.
    bool ReadMotions(btScalar timeStep, qcScene* scene);
    /// Forgets the multibodies that the world steps no more: they may be gone. Call it before what reads the world
    /// again in a step.
    void ForgetGoneMultiBodies()
    {
        FindMultiBodies(false);
    }
    /// Reads the present transforms as the targets. Meshes of objects that left the world, or are not finite, are
    /// removed from the scene.
    /// True if an object has moved.
    bool ReadTargets(const qcStartFunction& startOf, qcScene* scene);
    /// Moves multibodies by the pushes since the last call.
    void CommitMultiBodies();
    /// Moves multibodies whose motion was cut since the last call.
    void MoveMultiBodies();
    /// Returns the multibody of a link to the start of the step, if that is known. If it was not there, all its links
    /// are appended to `moved`.
    void ReturnMultiBody(const btCollisionObject* link, std::vector<const btCollisionObject*>* moved);
    /// Makes an object, and all links of its multibody, stay where they are until targets are read again. A mesh that
    /// the application moves through one is an unproven pair.
    void Hold(const btCollisionObject* object);
    /// Adapts the velocities of multibodies whose motion was cut.
    void UpdateMultiBodies() const;
    /// The pairs that collide and whose boxes overlap; at least one of the two moves, and one is not isUnmoved. Static
    /// meshes that were left out take part from here on if something moves near them.
    void FindPairs(qcScene* scene, std::vector<qcSweptPair>* pairs);
    /// The next step starts at the present transforms. Static meshes without a pair in this one are left out.
    void RecordEnds();
    /// True if all objects in the world that are finite are where RecordEnds has seen them.
    bool AreAtEnds();
    /// Calls function(object) for all links of multibodies that were pushed or cut since ReadTargets.
    template <typename Function> void ForEachLimitedLink(Function function) const
    {
        for (const auto& [body, multibody] : m_multibodies)
            if (multibody->IsLimited())
                multibody->ForEachCollider(function);
    }
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
    /// All objects but static meshes that are left out.
    const std::vector<qcSweptObject*>& Get() const
    {
        return m_sorted;
    }

  private:
    /// A translation of all dynamic objects since the previous step, by the application. Zero: there is none.
    struct Shift
    {
        btVector3 by{0, 0, 0};
        btScalar error = 0; ///< of a displacement, by rounding

        bool IsOf(const btTransform& from, const btTransform& to) const;
    };

    Shift FindCommonShift() const;
    void StartWherePut();
    qcSweptObject* Add(const btCollisionObject* object);
    static void FindStart(btScalar timeStep, qcSweptObject* swept);
    void ReadTriangles(qcSweptObject* swept, qcScene* scene) const;
    void EndDeformations() const;
    void RemoveGone(qcScene* scene);
    btScalar TravelNear(const btCollisionObject* object) const;
    void SortMovingMeshes();
    bool MayPass(const btCollisionObject* object, btScalar halfWidth) const;
    bool TakesCores(const btCollisionObject* object);
    qcSweptObject& ReadTarget(btCollisionObject* object, bool takesCores, qcScene* scene);
    bool ReadObjects(qcScene* scene);
    void FindMultiBodies(bool adds);
    qcSweptMultiBody* FindMultiBody(const btCollisionObject* object) const;
    void FindPlanes();
    void FindFloors(qcSweptObject* swept) const;
    void WakeNearMoving(qcScene* scene);
    void LetRest();
    bool IsLeftOut(const qcSweptObject& a, const qcSweptObject& b) const;
    bool Collide(const qcSweptObject& a, const qcSweptObject& b) const;

    const qcBatchSettings& m_settings;
    qcAxisCache& m_axes;
    qcConvexCores m_cores{qcCoreSize}, m_innerCores{qcInnerCoreSize};
    qcContactDepths m_depths;
    btScalar m_timeStep = 0;
    /// Of those whose contact is computed here, by the lower ends of their boxes along x.
    std::vector<const qcSweptObject*> m_movingMeshes;
    btScalar m_widestMesh = 0; ///< the largest extent of these along x
    const btCollisionObject* m_notFinite = nullptr;
    size_t m_coreCount = 0;     ///< objects whose convex shapes are swept
    bool m_anyOurs = false;     ///< there is an object whose contact is computed here
    bool m_anyFreeMesh = false; ///< there is one that is no static or kinematic body
    std::unordered_map<qcObjectKey, std::unique_ptr<qcSweptObject>, qcObjectKeyHash> m_objects;
    std::vector<qcSweptObject*> m_sorted;
    qcRestingMeshes m_resting; ///< what m_sorted lacks of the objects
    /// Of bodies with Bullet's continuous collision that are not among the objects, where starts are marked.
    std::unordered_map<qcObjectKey, btTransform, qcObjectKeyHash> m_continuousStarts;
    std::unordered_map<const btMultiBody*, std::unique_ptr<qcSweptMultiBody>> m_multibodies;
    std::unordered_map<const btCollisionShape*, uint64_t> m_changes; ///< calls of InvalidateShape
    std::vector<const btCollisionObject*> m_planes;                  ///< static ones
    std::vector<qcSweptObject*> m_byLower;                           ///< along the first axis
    qcIdCounter m_numbers;
    uint64_t m_step = 0;
    bool m_isMarked = false;    ///< the starts of the present step
    bool m_findsStarts = false; ///< while motions are read: starts are not marked
};

#endif
