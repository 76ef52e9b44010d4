// A translation of all objects of a world by the application.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_COMMON_SHIFT_H
#define QC_GLUE_MESH_CONTACT_LIMITS_COMMON_SHIFT_H

#include "common/object_motion.h"
#include "mesh_contact/limits/swept_object.h"

/// Origins of all rigid bodies that Bullet moves, those that limits ignore included.
class qcBodyOrigins
{
  public:
    /// The step starts here. Without this call starts follow from velocities. O(objects).
    void MarkStarts(const btCollisionWorld& world);
    /// A step ends here. O(objects).
    void RecordEnds(const btCollisionWorld& world);
    /// Calls function(from, to) for the bodies that are where they were in the world's list: with their origins at the
    /// end of the previous step, and at the start of the one that ends now. It ends at false, and returns it.
    template <typename Function> bool ForEach(const btCollisionWorld& world, btScalar timeStep, Function function) const
    {
        for (const Origin& origin : m_origins)
            if (IsThere(world, origin) && !function(origin.end, StartOf(origin, timeStep)))
                return false;
        return true;
    }

  private:
    struct Origin
    {
        const btRigidBody* body;
        int index; ///< in the world
        btVector3 end, start;
    };

    static bool IsThere(const btCollisionWorld& world, const Origin& origin)
    {
        const btCollisionObjectArray& objects = world.getCollisionObjectArray();
        return origin.index < objects.size() && objects[origin.index] == origin.body &&
               btRigidBody::upcast(objects[origin.index]) != nullptr;
    }
    btVector3 StartOf(const Origin& origin, btScalar timeStep) const;

    std::vector<Origin> m_origins;
    bool m_isMarked = false;
};

/// The translation by which the application has moved all bodies that Bullet moves since the previous step: these
/// objects, and the others. None if there is none.
qcTranslation qcFindCommonShift(const std::vector<qcSweptObject*>& objects, const qcBodyOrigins& others,
                                const btCollisionWorld& world, btScalar timeStep);

#endif
