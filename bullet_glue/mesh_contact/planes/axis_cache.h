// Caches of small meshes from step to step: the meshes as hulls, and the last separating axis of each pair.
#ifndef QC_GLUE_MESH_CONTACT_PLANES_AXIS_CACHE_H
#define QC_GLUE_MESH_CONTACT_PLANES_AXIS_CACHE_H

#include "common/live_objects.h"
#include "common/object_key.h"
#include "common/shape_owners.h"
#include "common/support_mesh.h"
#include "mesh_contact/scene/batch_scene.h"

#include <memory>
#include <unordered_map>

class qcAxisCache
{
  public:
    explicit qcAxisCache(const qcBatchSettings& settings) : m_settings(settings)
    {
    }
    /// Begins a step. Meshes and axes that have not been used for many steps are removed.
    void BeginStep();
    /// Objects may have left the world since the last call in this step, and others may have come.
    void BeginObjects()
    {
        m_live.reset();
    }
    /// The object's mesh; null if it does not consist of one small mesh.
    const qcSupportMesh* FindMesh(const btCollisionObject* object);
    /// Makes room for the axis of a pair.
    void AddPair(const btCollisionObject* a, const btCollisionObject* b);
    /// The kept axis of a pair, from the first object to the second; 0 for a new pair. It turns with the object that
    /// entered the world first. This and KeepAxis may run on several threads at once for different pairs.
    btVector3 GetAxis(const btCollisionObject* a, const btTransform& atA, const btCollisionObject* b,
                      const btTransform& atB);
    /// Only after AddPair in the same step.
    void KeepAxis(const btCollisionObject* a, const btTransform& atA, const btCollisionObject* b,
                  const btTransform& atB, const btVector3& axis);
    /// Keeps until the next step that the meshes of two objects touch along faces at these places.
    void KeepTouching(const btCollisionObject* a, const qcPlacedSupport& atA, const btCollisionObject* b,
                      const qcPlacedSupport& atB);
    /// True if KeepTouching has been called in this step for two objects at the same places.
    bool AreTouching(const btCollisionObject* a, const qcPlacedSupport& atA, const btCollisionObject* b,
                     const qcPlacedSupport& atB) const;
    /// Call it after the triangles of a shape have changed.
    void InvalidateShape(const btCollisionShape* shape);

  private:
    struct Mesh
    {
        std::shared_ptr<const qcSupportMesh> mesh; ///< null: it is not small
        uint64_t revision = 0;
        uint64_t step = 0;    ///< the last one that used it
        qcShapeOwners owners; ///< of one of Bullet's own shapes
    };

    struct Axis
    {
        btVector3 axis;
        uint64_t step; ///< the last one that used it
    };

    /// Two meshes that touch: first that of the object that entered the world first.
    struct Touch
    {
        qcPlacedSupport first, second;
    };

    bool IsKnown(const btCollisionObject* object, qcShapeOwners* owners);
    static uint64_t KeyOf(const btCollisionObject* a, const btCollisionObject* b);

    const qcBatchSettings& m_settings;
    std::unique_ptr<qcLiveObjects> m_live; ///< null: no object was new since BeginObjects
    std::unordered_map<const btCollisionShape*, Mesh> m_meshes;
    qcHashTable<uint64_t, Axis> m_axes;     ///< by the unique ids of two objects
    qcHashTable<uint64_t, Touch> m_touches; ///< likewise; all their meshes exist
    uint64_t m_step = 0;
};

#endif
