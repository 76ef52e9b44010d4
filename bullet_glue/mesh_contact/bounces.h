// Restitution. Bullet's solver stops bodies at a contact point at a distance, and would take the speed that closes it
// from that of the bounce: hardly anything bounced. Where bodies overlap, it gives each pair of a row all of its
// parting speed, and the row energy. So it solves points without restitution, and bounces are added once the transforms
// are integrated.
#ifndef QC_GLUE_MESH_CONTACT_BOUNCES_H
#define QC_GLUE_MESH_CONTACT_BOUNCES_H

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

#include <array>
#include <mutex>
#include <unordered_map>

class btDynamicsWorld;

/// A point at which two bodies may bounce in the present step.
struct qcBounceMark
{
    btVector3 armA, armB;     ///< from the bodies' centres to the point, before the step
    btScalar restitution = 0; ///< of the point, and 0 if there is no bounce
    btScalar approach = 0;    ///< speed at which the bodies close in on each other before the solver
    btScalar distance = 0;    ///< of the two before the step
};

class qcBounces
{
  public:
    /// Apply will be called in each step. Without this call Mark does nothing: restitution is left to the solver.
    void Enable()
    {
        m_isEnabled = true;
    }
    /// Before the solver: keeps what bounces, and sets the restitution of its points to 0. Bodies of the manifold
    /// respond to each other. It may run on several threads at once.
    void Mark(btPersistentManifold* manifold);
    /// After the solver: bodies that touch at these points, or that it has stopped there, bounce. Points have their
    /// restitution again.
    void Apply(btDynamicsWorld* world);

  private:
    struct Marks
    {
        const btCollisionObject *body0, *body1; ///< a later manifold may have the address of one that is gone
        std::array<qcBounceMark, MANIFOLD_CACHE_SIZE> points;
    };

    std::unordered_map<const btPersistentManifold*, Marks> m_marks;
    std::mutex m_mutex;
    bool m_isEnabled = false;
};

#endif
