// Depths of objects in each other where Bullet has contact points, and the motions that this contact has stopped.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_CONTACT_DEPTHS_H
#define QC_GLUE_MESH_CONTACT_LIMITS_CONTACT_DEPTHS_H

#include <LinearMath/btScalar.h>

#include <unordered_map>

class btCollisionObject;
class btDispatcher;
class btPersistentManifold;

/// Depths of Bullet's points, margins included, where contact of the step was found. Its penetration algorithms are not
/// exact.
class qcContactDepths
{
  public:
    /// All depths are 0.
    void Clear()
    {
        m_entries.clear();
    }
    /// Reads all manifolds of awake objects that respond to each other. Call it before the contacts of soft bodies are
    /// published: their manifolds stay when an action removes a body. O(manifolds).
    void Read(btDispatcher* dispatcher, btScalar timeStep);
    /// The largest depth of an object in another one; 0 if it is small.
    btScalar DepthOf(const btCollisionObject* object) const;
    /// How much further an object would have moved in the step if the contact that pushes most had been lost; 0 if that
    /// is not much more than gravity would make of it.
    btScalar HeldOffOf(const btCollisionObject* object) const;

  private:
    void Add(const btCollisionObject* object, btScalar depth, btScalar heldOff);

    struct Entry
    {
        btScalar depth = 0, heldOff = 0;
    };
    std::unordered_map<const btCollisionObject*, Entry> m_entries;
};

#endif
