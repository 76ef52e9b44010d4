// Decides whether the last batch holds for the pairs of a step.
#ifndef QC_GLUE_MESH_CONTACT_BATCH_VALIDITY_H
#define QC_GLUE_MESH_CONTACT_BATCH_VALIDITY_H

#include "mesh_contact/batch_scene.h"

/// The first pair of a step has the objects of all pairs checked, so that results don't depend on the order of pairs.
class qcBatchValidity
{
  public:
    explicit qcBatchValidity(qcBatchScene& scene) : m_scene(scene)
    {
    }

    /// Checks all pairs of the world. True if the last gathering holds for each of them that the library computes.
    bool Check();
    /// True if the object is in the state in which the last check found it.
    bool IsAsChecked(const btCollisionObject* object) const;
    /// Number of the last check; 0: none.
    unsigned GetNumber() const
    {
        return m_number;
    }

  private:
    bool IsValid(const btCollisionObject* object, const qcBatchObject& gathered);
    const qcBatchObject* CheckObject(const btCollisionObject* object);

    qcBatchScene& m_scene;
    unsigned m_number = 0;
    std::vector<qcBatchMesh> m_present; ///< scratch
};

#endif
