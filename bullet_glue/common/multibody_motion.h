// How pushes on its links move a multibody.
//
// A push on one link moves all others, too: by Featherstone's algorithm, in Bullet's btMultiBody. It takes a force on
// the joints to their acceleration; so it takes an impulse to a velocity, and a push, an impulse times the time step,
// to a displacement.
#ifndef QC_GLUE_COMMON_MULTIBODY_MOTION_H
#define QC_GLUE_COMMON_MULTIBODY_MOTION_H

#include "common/multibody_joints.h"
#include "common/rigid_displacement.h"

#include <array>
#include <cstddef>
#include <vector>

class qcMultiBodyMotion
{
  public:
    /// Displacements of the base, rotation first, then of the joints: as Bullet orders velocities.
    using Coordinates = std::vector<btScalar>;

    /// The multibody where Bullet's step has led it. `start`: where the step began; null: not known.
    qcMultiBodyMotion(btMultiBody& body, const qcJointPositions* start);

    /// Adds a link, -1 for the base, and returns its index here. O(joints).
    size_t AddLink(int link);
    /// False for a link that nothing can move, since all joints up to a fixed base are fixed, and for links of a
    /// multibody that no world has stepped.
    bool CanMove(size_t link) const;
    /// The displacement of a link if `push` acts on it at `arm` from its centre.
    qcRigidDisplacement DisplacementBy(size_t link, const btVector3& arm, const btVector3& push) const;
    /// The displacement of a link where the coordinates are displaced by this.
    qcRigidDisplacement DisplacementBy(size_t link, const Coordinates& moved) const
    {
        return DisplacementOf(m_links[link], moved);
    }
    /// Displacements R of the coordinates, of which the sum of R R' is the inverse inertia of the joints: a push F on
    /// the coordinates displaces these by R R'F. As many as there are directions in which something moves. O(joints^3).
    std::vector<Coordinates> FindRoots() const;
    /// Adds the displacement of all links by this push. O(links here * joints).
    void Push(size_t link, const btVector3& arm, const btVector3& push);
    /// Likewise by this displacement of the coordinates.
    void Push(const Coordinates& moved);
    /// The displacement of a link since the last Commit.
    const qcRigidDisplacement& Displacement(size_t link) const
    {
        return m_links[link].displacement;
    }
    /// Moves the joints, and the colliders of all links, by the pushes since the last call. False: there were none.
    bool Commit();
    /// The velocity of the point at `arm` from a link's centre.
    btVector3 VelocityAt(size_t link, const btVector3& arm) const;
    /// Changes the velocities of all joints by an impulse on a link.
    void ApplyImpulse(size_t link, const btVector3& arm, const btVector3& impulse);
    /// Changes velocities by the motion of Commit since the last call.
    void UpdateVelocities(btScalar timeStep);
    /// Undoes all motion by pushes, and returns to the velocities of Bullet's own solvers.
    void Restore();
    /// Returns the multibody to where the step began, at rest. False: that is not known.
    bool ReturnToStart();
    /// True after ReturnToStart: pushes are to move it no further.
    bool HasReturned() const
    {
        return m_hasReturned;
    }
    /// Makes it unable to return, where the application has moved a link since the previous step: the step starts
    /// before that motion, and not where it began.
    void ForgetStart()
    {
        m_start = nullptr;
    }

    const btMultiBody& Body() const
    {
        return m_body;
    }
    /// Calls function(collider) for each link that has one, if pushes have moved the multibody.
    template <typename Function> void ForEachMovedCollider(Function function) const
    {
        if (!m_hasMoved)
            return;
        if (m_body.getBaseCollider() != nullptr)
            function(m_body.getBaseCollider());
        for (int i = 0; i < m_body.getNumLinks(); i++)
            if (m_body.getLinkCollider(i) != nullptr)
                function(m_body.getLinkCollider(i));
    }

  private:
    struct Link
    {
        //  Three rotations, then three translations: the derivative of each by the coordinates; by a torque or push of
        //  1, the displacement of the coordinates, and that of the link itself.
        std::array<Coordinates, 6> jacobian, response;
        std::array<qcRigidDisplacement, 6> yield;
        qcRigidDisplacement displacement; ///< since the last Commit
    };

    void FindDisplacements();
    void AddResponse(size_t link, const btVector3& arm, const btVector3& push, Coordinates* moved) const;
    void FindJacobian(int link, std::array<Coordinates, 6>* jacobian) const;
    void FindResponse(const Coordinates& force, Coordinates* response) const;
    static qcRigidDisplacement DisplacementOf(const Link& link, const Coordinates& moved);
    void ForgetPushes();
    void Clear();
    void KeepFixed(Coordinates* moved) const;
    void SetVelocities(const Coordinates& velocities);

    btMultiBody& m_body;
    std::vector<Link> m_links;
    Coordinates m_pushed, m_moved; ///< since the last Commit; since the last UpdateVelocities
    bool m_hasMoved = false, m_hasReturned = false;
    const qcJointPositions* m_start;
    //  After Bullet's own solvers.
    qcJointPositions m_solved;
    Coordinates m_solvedVelocities;
};

#endif
