// Contacts of the previous step of bodies that carry or press something, with their elasticity.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_CONTACTS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_CONTACTS_H

#include "soft_body/response/position_constraints.h"
#include "soft_body/response/present_objects.h"
#include "soft_body/response/rebounds.h"

#include <memory>

class qcElasticContacts
{
  public:
    /// `elasticity`: of the world's soft bodies; it decides which of them count.
    void SetElasticity(std::unique_ptr<qcNodeElasticity> elasticity)
    {
        m_elasticity = std::move(elasticity);
    }
    /// Keeps the contacts of soft bodies with each other and with rigid ones, at the end of a step, but for those of
    /// tangled bodies: parts of them are on the wrong side.
    void Keep(qcSoftBodyScene& scene, const qcSoftTangles& tangles, const std::vector<qcSoftConstraint>& constraints);
    /// Reads where nodes are before Bullet's solver moves them to where links and other constraints have them.
    void ReadPredicted(qcSoftBodyScene& scene);
    /// Moves bodies that carry or press something, and what they carry, as the kept contacts require; velocities
    /// follow. Bullet has moved all bodies in this step.
    void Solve(qcSoftBodyScene& scene, qcPresentObjects* present, btScalar timeStep);

  private:
    /// A contact at the end of a step. Side A is a soft body; side B another one, or a rigid object.
    struct Kept
    {
        qcObjectKey soft[2]{{nullptr, -1}, {nullptr, -1}}; ///< by side; null: side B is rigid
        int nodeCount = 0;
        int sides[6] = {0, 0, 0, 0, 0, 0};
        uint32_t nodes[6] = {0, 0, 0, 0, 0, 0};
        btScalar weights[6] = {0, 0, 0, 0, 0, 0}; ///< negative on side B
        qcHeldPoint rigid;                        ///< without an object: side B is a soft body
        btVector3 normal{0, 0, 0};                ///< between soft bodies: towards side A
        btScalar thickness = 0, friction = 0;
        bool isStrain = false;        ///< the soft body needs its elasticity to bear the rigid one
        btVector3 predicted{0, 0, 0}; ///< weighted sum of its nodes before Bullet's solver
    };
    /// The contact of a spring, and what has moved its sides.
    struct Sides
    {
        const Kept* kept;
        qcSceneSoftBody* soft[2];
        btVector3 rigidMotion; ///< of the rigid body's point in this step
        btVector3 sprung;      ///< motion of its nodes by Bullet's solver
    };

    void FindCovered(qcSoftBodyScene& scene);
    bool IsUnderLoad(const qcSceneSoftBody& soft) const;
    void FindUnderLoad(qcSoftBodyScene& scene, const std::vector<qcSoftConstraint>& constraints);
    bool IsCovered(qcSoftBodyScene& scene, const qcSceneSoftBody& soft) const
    {
        return m_isCovered[size_t(&soft - scene.Bodies().data())];
    }
    bool MakeKept(qcSoftBodyScene& scene, const qcSoftTangles& tangles, const qcSoftConstraint& constraint,
                  Kept* kept) const;
    bool AddRigidSide(const Kept& kept, qcPresentObjects* present, const qcSceneSoftBody& soft, btVector3* start,
                      btVector3* end, qcElasticSpring* spring);
    void AddSpring(qcSoftBodyScene& scene, const Kept& kept, qcPresentObjects* present);
    qcNodeElasticity::LoadedBody* FindLoaded(const qcSceneSoftBody* soft);
    void AddLoaded(qcSceneSoftBody* soft, btScalar load);
    bool IsLoad(const Kept& kept) const;
    bool IsStrained(size_t spring) const;
    void FindLoads();
    void SpreadLoads();
    void LeaveUnloaded();
    void NumberNodes();
    void LimitRebounds();

    std::vector<bool> m_isCovered;        ///< by soft body of the scene
    std::vector<qcObjectKey> m_underLoad; ///< soft bodies that count in the next step for what lies on them
    std::vector<Kept> m_kept;
    std::vector<qcElasticSpring> m_springs;
    std::vector<Sides> m_sides; ///< by spring
    std::vector<qcNodeElasticity::LoadedBody> m_loaded;
    /// Pairs of a soft body and a rigid one that presses on it, as of the last step.
    std::vector<std::pair<qcObjectKey, qcObjectKey>> m_loads;
    std::unique_ptr<qcNodeElasticity> m_elasticity;
    qcRebounds m_rebounds;
    qcElasticSystem m_system;
};

#endif
