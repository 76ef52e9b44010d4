/// @file
/// Bullet's solver for heaps and stacks, in which the weight of many bodies presses on a few:
///
///     qcStackingSolver solver;
///     btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
#ifndef QUICKCULLIDE_BULLET_SOLVER_H
#define QUICKCULLIDE_BULLET_SOLVER_H

#include "base.h"

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

#include <vector>

/// btSequentialImpulseConstraintSolver with shock propagation at the end of each step (Guendelman, Bridson, Fedkiw:
/// Nonconvex Rigid Bodies with Stacking, SIGGRAPH 2003, section 7). Sequential impulses need as many iterations as a
/// heap has layers, and where a light body lies under a heavy one as many as the heavy one has times its mass. What is
/// left after the iterations of btContactSolverInfo presses the lowest bodies into the floor. Here bodies are then
/// visited from the static ones upwards: each stops against those that were visited before it, which don't give way any
/// more. Kinetic energy does not rise by it: what comes towards the visited body does not throw it.
///
/// Bodies don't slide on those visited before, either, as far as the load of their contact points allows: in the
/// directions of SOLVER_USE_2_FRICTION_DIRECTIONS (btContactSolverInfo::m_solverMode), otherwise in two of the pass's
/// own, since Bullet's single one turns with the speed. A single one that the application has set
/// (BT_CONTACT_FLAG_LATERAL_FRICTION_INITIALIZED) stays as Bullet has solved it.
///
/// Split impulses (btContactSolverInfo::m_splitImpulse) are treated likewise. Bullet applies them without regard to
/// contact points that are still apart, such as those of a body that reaches the floor within the step.
///
/// Left as Bullet has solved them: bodies that no chain of contact points connects with a static or kinematic one,
/// bodies with joints, and contact points with compliance (CFM, stiffness or damping).
///
/// O(n log n) of the bodies and contact points of an island, on top of Bullet's iterations.
/// Thread-safety: as its base class, which is for one island at a time; an instance may be part of a
/// btConstraintSolverPoolMt.
ATTRIBUTE_ALIGNED16(class) QC_API qcStackingSolver : public btSequentialImpulseConstraintSolver
{
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    qcStackingSolver();
    ~qcStackingSolver() override;

    /// Makes room for the contact points of a step, those of all manifolds: without it the solver's arrays grow, and
    /// are copied, in the step in which a body breaks into hundreds. Call it between steps, once for each solver of a
    /// btConstraintSolverPoolMt. Room is never given back. About 1 KB a point, 2 KB in double precision: Bullet's
    /// arrays crash if there is no memory. 0 or less: nothing happens.
    void reserveContacts(int points);

  protected:
    /// Bullet's iterations, then shock propagation.
    btScalar solveGroupCacheFriendlyIterations(btCollisionObject * *bodies, int bodyCount,
                                               btPersistentManifold** manifolds, int manifoldCount,
                                               btTypedConstraint** constraints, int constraintCount,
                                               const btContactSolverInfo& info, btIDebugDraw* drawer) override;

  private:
    /// A contact point of the visited body.
    struct Contact;
    struct FrictionDef;

    bool IsFixed(int body) const;
    void ListContacts();
    void FindLevels();
    void SortBodies();
    template <class Pass> void ReadContacts(int body);
    void ReadFrictions(int row, bool isFirst, Contact* contact);
    void AddFriction(int ownIndex, int otherIndex, const FrictionDef& def, Contact* contact);
    template <class Pass> static btScalar Solve(Contact * contact, btSolverBody * own);
    template <class Pass> void Visit(int body);

    std::vector<int> m_firstOf, m_contactsOf; ///< contact points by body
    std::vector<int> m_levels;          ///< by body: number of contacts from a static one; -1: none, or it has joints
    std::vector<int> m_order, m_places; ///< bodies in the order of visits, and the place of each in it
    std::vector<Contact> m_contacts;
};

#endif
