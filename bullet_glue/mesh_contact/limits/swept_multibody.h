// A multibody with links near meshes: where its joints start a step, and its motion in the step, which is cut as a
// whole.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_MULTIBODY_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_MULTIBODY_H

#include "common/multibody_joints.h"
#include "common/multibody_motion.h"

#include <memory>

struct qcSweptObject;

class qcSweptMultiBody
{
  public:
    explicit qcSweptMultiBody(btMultiBody& body)
        : m_body(body), m_start(body), m_target(body), m_recorded(body), m_put(body)
    {
    }

    /// Does what ReadTarget does, and finds the start of the step that ends now: the end of the previous one if the
    /// velocities have moved the joints from there since, up to 2 cm and half of the motion. If not, or if it is new,
    /// the application has put it elsewhere, and it starts where the velocities took it from. O(joints).
    void ReadMotion(btScalar timeStep);
    /// The application has moved the whole world: links and base that it has moved start where they are.
    void StartWherePut();
    /// Reads where the joints are as the target, which is reached in full.
    void ReadTarget();
    /// The next step starts where the joints are.
    void RecordEnd();
    /// True if Bullet moves the base.
    bool HasFreeBase() const
    {
        return !m_body.isBaseStaticOrKinematic();
    }
    /// True if joints move this link or base, and the start of the multibody is known.
    bool IsDynamic(const btMultiBodyLinkCollider& link) const;
    /// Where the collider of such a link starts the step.
    const btTransform& StartOf(const btCollisionObject* link) const;
    /// False for such a link that no joint moves, since all up to a base that Bullet does not move are fixed.
    bool CanMove(const btCollisionObject* link) const;
    /// Takes part with a link that joints move, whose end follows its motion until the next step.
    void Add(qcSweptObject* swept);
    /// True if planes push it: where it was stopped in the previous step, too. The first time it is cut back: planes at
    /// single points would tilt what strikes flush, and contact of the next step is mostly all that it needs.
    bool Yields() const
    {
        return m_wasStopped;
    }
    /// The displacement of a link if `push` acts at `arm` from its centre.
    qcRigidDisplacement DisplacementBy(const qcSweptObject& link, const btVector3& arm, const btVector3& push);
    /// Moves the ends of all links by a push on one.
    void Push(const qcSweptObject& link, const btVector3& arm, const btVector3& push);
    /// Moves the joints by all pushes since the last call, and the ends to where that leads. The target is there.
    void CommitPushes();
    btVector3 VelocityAt(const qcSweptObject& link, const btVector3& arm);
    /// Changes the velocities of all joints by an impulse on a link. `isDriven`: from an object that the application
    /// moves, which may give it energy.
    void ApplyImpulse(const qcSweptObject& link, const btVector3& arm, const btVector3& impulse, bool isDriven);
    /// The part of its motion that it makes.
    btScalar Fraction() const
    {
        return m_fraction;
    }
    /// Makes no more than this part of the motion from now on. False: it makes no more already.
    bool CutTo(btScalar part);
    /// Moves the joints and all colliders to the start of the step; what the application moves stays. The links count
    /// as limited. False: they are there.
    bool ReturnToStart(const btVector3& gravity);
    /// Moves the joints, all colliders and the ends to where that part ends.
    void Move();
    /// If it was pushed or cut: slows down all joints so that it has no more kinetic energy than at the target, and
    /// what driven impulses have given it, less what gravity has given it for the part of a fall that it doesn't make.
    /// Equal velocities of joints have more energy in some positions than in others.
    void UpdateVelocities(const btVector3& gravity);
    /// True if it was pushed or cut since ReadTarget.
    bool IsLimited() const
    {
        return m_hasLeft;
    }
    /// Calls function(collider) for each link that has one.
    template <typename Function> void ForEachCollider(Function function) const
    {
        for (int link = -1; link < m_body.getNumLinks(); link++)
            if (const btCollisionObject* collider = ColliderOf(link))
                function(collider);
    }

  private:
    /// A link that takes part.
    struct Member
    {
        qcSweptObject* swept;
        size_t index;       ///< in the motion
        btTransform before; ///< the end without the pushes since CommitPushes
    };

    using Places = std::vector<btTransform>; ///< of the colliders, the base first

    const btCollisionObject* ColliderOf(int link) const;
    Places ReadColliders() const;
    Places PlacesAt(const qcJointPositions& joints);
    qcJointPositions StepFrom(const qcJointPositions& from, btScalar timeStep);
    btScalar HalfSize() const;
    btScalar LargestDisplacement(const Places& from, const Places& to) const;
    bool IsExplained(const qcJointPositions& expected);
    void FindStart(btScalar timeStep);
    void KeepTarget();
    qcMultiBodyMotion& Motion();
    size_t IndexOf(const qcSweptObject& link);
    void ReadEnds();

    btMultiBody& m_body;
    qcJointPositions m_start, m_target, m_recorded, m_put;
    Places m_starts, m_targets;
    Places m_puts;    ///< the colliders at m_put; none: it starts there, or the application moves nothing
    Places m_records; ///< of the joints' end of the previous step; none: it is new
    btVector3 m_targetMoment{0, 0, 0}; ///< sum of masses times places, at the target
    btScalar m_allowedEnergy = 0;      ///< kinetic: at the target, and by driven impulses
    bool m_hasLeft = false;            ///< the joints are not at the target
    std::vector<Member> m_members;
    std::unique_ptr<qcMultiBodyMotion> m_motion; ///< null: no push needs it yet
    bool m_hasStart = false, m_isMoved = true;
    bool m_wasStopped = false, m_isStopped = false; ///< in the previous step; in this one
    btScalar m_fraction = 1;
};

#endif
