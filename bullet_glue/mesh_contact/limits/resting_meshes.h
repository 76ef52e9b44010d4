// Static meshes that have not changed, and that nothing has been near. A step only compares their transforms: worlds
// may have thousands.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_RESTING_MESHES_H
#define QC_GLUE_MESH_CONTACT_LIMITS_RESTING_MESHES_H

#include "mesh_contact/limits/swept_object.h"

#include <unordered_map>

class qcRestingMeshes
{
  public:
    using Objects = std::vector<qcSweptObject*>;

    /// Begins a pass over all objects of the world.
    void BeginObjects();
    /// True if the object rests. `index`: its index in the world. One that has changed wakes.
    bool Rests(const btCollisionObject* object, size_t index, Objects* awake);
    /// True if the object can rest: a static one with one mesh that has not moved in this step.
    static bool CanRest(const qcSweptObject& swept);
    /// From now on the object rests, until it wakes.
    void Add(qcSweptObject* swept);
    /// Wakes the objects whose boxes overlap one. Objects that wake rest no more, and are appended to `awake`.
    void WakeNear(const btVector3& lower, const btVector3& upper, Objects* awake);
    /// Wakes all objects, and forgets them.
    void WakeAll(Objects* awake);
    /// Wakes those that were not found in the world since BeginObjects.
    void WakeGone(Objects* awake);
    /// Call it before the entry of an object, which is awake, is removed.
    void Forget(const qcObjectKey& key);
    /// True if contact of one of them with any other mesh is computed here.
    bool AnyOurs() const
    {
        return m_oursCount > 0;
    }

  private:
    struct Mesh
    {
        qcObjectKey key;
        qcSweptObject* swept; ///< null: forgotten
        bool isAsleep;        ///< the object rests; otherwise it may do so again, unchanged
        btTransform place;
        const btCollisionShape* shape;
        uint64_t revision; ///< of a qcMeshShape; 0: it is another shape
        btVector3 scaling; ///< of another shape
        btVector3 lower, upper;
        uint64_t step; ///< the last one that found it in the world
    };
    /// A mesh by the lower end of its box along x.
    struct Entry
    {
        btScalar lower;
        uint32_t mesh;
    };

    static bool IsUnchanged(const Mesh& mesh, const btCollisionObject* object);
    uint32_t IndexOf(const qcObjectKey& key) const;
    void Wake(Mesh* mesh, Objects* awake);
    void Forget(Mesh* mesh);
    void RemoveForgotten();
    void IndexLoose();

    std::vector<Mesh> m_meshes;
    std::unordered_map<qcObjectKey, uint32_t, qcObjectKeyHash> m_indices; ///< of meshes that are not forgotten
    std::vector<uint32_t> m_byObject; ///< by index in the world: the mesh that was found there in the last step
    std::vector<std::vector<Entry>> m_byWidth; ///< by the exponent of their extents along x, each sorted
    size_t m_indexedCount = 0;                 ///< meshes in m_byWidth: the first ones
    size_t m_forgottenCount = 0, m_asleepCount = 0, m_oursCount = 0;
    size_t m_foundCount = 0; ///< meshes asleep that were found in the world since BeginObjects
    uint64_t m_step = 0;
};

#endif
