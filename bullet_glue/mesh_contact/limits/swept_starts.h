// Where the objects of a world start a step: where the previous step has left them, or where they are when its start is
// marked, unless the application has put them elsewhere since.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_STARTS_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_STARTS_H

#include "common/object_key.h"
#include "common/object_motion.h"
#include "mesh_contact/limits/swept_object.h"

#include <unordered_map>

class qcSweptStarts
{
  public:
    /// The step starts here: callers set the starts of dynamic objects. Without this call within the step, starts
    /// follow from velocities.
    void BeginMarks()
    {
        m_areMarked = true;
        m_continuous.clear();
    }
    /// Keeps the start of a body with Bullet's continuous collision that is not among the swept objects.
    void MarkContinuous(const btCollisionObject& object)
    {
        m_continuous.emplace(qcObjectKey(&object), object.getWorldTransform());
    }
    bool AreMarked() const
    {
        return m_areMarked;
    }
    /// Finds the start of an object that has its target, from the one that was marked or the end of the previous step.
    void Find(btScalar timeStep, qcSweptObject* swept) const;
    /// Likewise, of a dynamic object whose start is not marked: the end of the previous step if the velocities have
    /// moved it from there since. If not, or if it is new, the application has put it elsewhere, and it starts where
    /// the velocities took it from.
    static void FindByVelocities(btScalar timeStep, qcSweptObject* swept);
    /// An object that Bullet does not move, and that the application has put elsewhere, starts there. `shift`: see
    /// qcFindCommonShift.
    static void StartWherePut(const qcTranslation& shift, btScalar timeStep, qcSweptObject* swept);
    void EndStep()
    {
        m_areMarked = false;
        m_continuous.clear();
    }

  private:
    bool m_areMarked = false;                                                   ///< in the present step
    std::unordered_map<qcObjectKey, btTransform, qcObjectKeyHash> m_continuous; ///< see MarkContinuous
};

#endif
