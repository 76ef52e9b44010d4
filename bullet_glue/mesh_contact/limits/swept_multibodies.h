// The multibodies of a world, with their motion in a step.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_MULTIBODIES_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_MULTIBODIES_H

#include "mesh_contact/limits/swept_multibody.h"
#include "mesh_contact/scene/batch_scene.h"

class qcSweptMultiBodies
{
  public:
    explicit qcSweptMultiBodies(const qcBatchSettings& settings) : m_settings(settings)
    {
    }

    /// The multibody of a link that its joints move, or null.
    qcSweptMultiBody* Find(const btCollisionObject* link) const;
    /// Reads the motions of the step that ends now. `adds`: also of multibodies that are new in the world.
    void ReadMotions(btScalar timeStep, bool adds);
    /// Forgets multibodies that the world steps no more: they may be deleted. Call it before the world is read again
    /// within a step.
    void ForgetGone()
    {
        Collect(false);
    }
    /// Returns the multibody of a link to the start of the step, if that is known. If it was not there, all its links
    /// are appended to `moved`.
    void ReturnToStart(const btCollisionObject* link, std::vector<const btCollisionObject*>* moved);
    void UpdateVelocities(); ///< of all; see qcSweptMultiBody
    /// Calls a function of qcSweptMultiBody for all: ForAll(&qcSweptMultiBody::Move).
    void ForAll(void (qcSweptMultiBody::*function)())
    {
        for (auto& [body, multibody] : m_multibodies)
            (*multibody.*function)();
    }
    /// Calls function(collider) for all links of multibodies that were pushed or cut since ReadTarget.
    template <typename Function> void ForEachLimitedLink(Function function) const
    {
        for (const auto& [body, multibody] : m_multibodies)
            if (multibody->IsLimited())
                multibody->ForEachCollider(function);
    }

  private:
    void Collect(bool adds);
    btVector3 Gravity() const;

    const qcBatchSettings& m_settings;
    std::unordered_map<const btMultiBody*, std::unique_ptr<qcSweptMultiBody>> m_multibodies;
};

#endif
