// A multibody with links near meshes: where its joints start a step, and its motion in the step, which is cut as a
// whole.
#ifndef QC_GLUE_MESH_CONTACT_SWEPT_MULTIBODY_H
#define QC_GLUE_MESH_CONTACT_SWEPT_MULTIBODY_H

#include "common/multibody_joints.h"

class qcSweptMultiBody
{
  public:
    explicit qcSweptMultiBody(btMultiBody& body) : m_body(body), m_start(body), m_target(body), m_recorded(body)
    {
    }

    /// Finds the start of the step that ends now: the end of the previous one if the velocities have moved the joints
    /// from there since. If not, or if it is new, the application has put it elsewhere, and it starts where the
    /// velocities took it from. Then does what ReadTarget does.
    void ReadMotion(btScalar timeStep);
    /// Reads where the joints are as the target, which is reached in full.
    void ReadTarget();
    /// The next step starts where the joints are.
    void RecordEnd();
    /// False for one that Bullet has not moved.
    bool CanBeCut() const
    {
        return m_hasStart;
    }
    /// Where the collider of a link, -1 for the base, starts the step. For one that can be cut.
    const btTransform& StartOf(int link) const
    {
        return m_starts[size_t(link + 1)];
    }
    /// The part of its motion that it makes.
    btScalar Fraction() const
    {
        return m_fraction;
    }
    /// Makes no more than this part of the motion from now on. False: it makes no more already.
    bool CutTo(btScalar part);
    /// Moves the joints and all colliders to where that part ends. False: they are there.
    bool Move();
    /// Slows it down by what gravity has given it for the part of a fall that it doesn't make, so that it gains no
    /// energy.
    void UpdateVelocities(const btVector3& gravity);

    const btMultiBody& Body() const
    {
        return m_body;
    }

    uint64_t step = 0; ///< the last one that found it in the world

  private:
    std::vector<btTransform> ReadColliders() const;

    btMultiBody& m_body;
    qcJointPositions m_start, m_target, m_recorded;
    std::vector<btTransform> m_starts, m_targets, m_records; ///< of the colliders, the base first
    btVector3 m_targetMoment{0, 0, 0};                       ///< sum of masses times places, at the target
    bool m_hasStart = false, m_isMoved = true;
    btScalar m_fraction = 1;
};

#endif
