// Decides which pairs of a step have to be queried.
#ifndef QC_GLUE_MESH_CONTACT_SCENE_BATCH_VALIDITY_H
#define QC_GLUE_MESH_CONTACT_SCENE_BATCH_VALIDITY_H

#include "mesh_contact/points/pair_contacts.h"
#include "mesh_contact/scene/batch_scene.h"

/// The first pair of a step has all pairs checked, so that results don't depend on the order of pairs.
class qcBatchValidity
{
  public:
    qcBatchValidity(qcBatchScene& scene, qcPairContacts& pairs) : m_scene(scene), m_pairs(pairs)
    {
    }

    /// Checks all pairs of the world that the library computes. True if what is known holds for each of them.
    bool Check();
    /// The pairs for which it does not hold.
    const std::vector<qcBatchPair>& GetDue() const
    {
        return m_due;
    }
    /// True if the object is in the state in which the last check found it.
    bool IsAsChecked(const btCollisionObject* object) const;
    /// An object of the last check that is not finite, or null. Pairs of such objects are left out.
    const btCollisionObject* NotFinite() const
    {
        return m_notFinite;
    }
    /// Number of the last check; 0: none.
    uint64_t GetNumber() const
    {
        return m_number;
    }

  private:
    bool IsChanged(const btCollisionObject* object, qcBatchObject* gathered) const;
    qcBatchObject* CheckObject(const btCollisionObject* object);
    bool Holds(const qcPairContact& pair, const qcBatchObject& a, const qcBatchObject& b) const;
    btScalar MaxTravel(const qcBatchPair& pair) const;
    bool AreFar(const qcBatchPair& pair, qcPairContact* contact) const;
    void CollectPairs();

    qcBatchScene& m_scene;
    qcPairContacts& m_pairs;
    std::vector<qcBatchPair> m_present; ///< pairs of the last check
    std::vector<qcBatchPair> m_due;     ///< likewise, in their order
    const btCollisionObject* m_notFinite = nullptr;
    uint64_t m_number = 0;
};

#endif
