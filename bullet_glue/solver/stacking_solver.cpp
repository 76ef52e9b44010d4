// Shock propagation after sequential impulses. Guendelman, Bridson, Fedkiw: Nonconvex Rigid Bodies with Stacking,
// SIGGRAPH 2003, section 7.
#include "quickcullide/bullet_solver.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <limits>

namespace
{
// Sweeps over the contact points of a body, at most, and until one changes speeds by no more than this part of the
// first: a box that falls flat does not turn about the corner that is solved first.
constexpr int s_maxSweeps = 10;
constexpr btScalar s_converged = btScalar(0.05);

/// One of the two sides of a row.
struct Side
{
    btVector3 normal, turn, angular;

    static Side First(const btSolverConstraint& row)
    {
        return {row.m_contactNormal1, row.m_relpos1CrossNormal, row.m_angularComponentA};
    }
    static Side Second(const btSolverConstraint& row)
    {
        return {row.m_contactNormal2, row.m_relpos2CrossNormal, row.m_angularComponentB};
    }
    /// A row of its own, at a point in world space.
    static Side At(const btVector3& point, const btVector3& direction, const btSolverBody& body)
    {
        const btVector3 turn = (point - body.getWorldTransform().getOrigin()).cross(direction);
        const btRigidBody* original = body.m_originalBody;
        return {direction, turn,
                original == nullptr ? btVector3(0, 0, 0)
                                    : original->getInvInertiaTensorWorld() * turn * original->getAngularFactor()};
    }

    btScalar Along(const btVector3& linear, const btVector3& rotation) const
    {
        return normal.dot(linear) + turn.dot(rotation);
    }
    btScalar InverseMass(const btSolverBody& body) const
    {
        return normal.dot(normal * body.internalGetInvMass()) + turn.dot(angular);
    }
};

/// Speed of a body's contact point before the impulses of the step, after the step's forces.
btScalar StartSpeed(const Side& side, const btSolverBody& body)
{
    return side.Along(body.m_linearVelocity + body.m_externalForceImpulse,
                      body.m_angularVelocity + body.m_externalTorqueImpulse);
}

/// Speed of a body's contact point that the impulses of the step have added.
btScalar AddedSpeed(const Side& side, btSolverBody& body)
{
    return side.Along(body.internalGetDeltaLinearVelocity(), body.internalGetDeltaAngularVelocity());
}

/// Speed at which a row's bodies part, beyond what the row requires. Its m_rhs is that for the velocities of the start.
btScalar ExcessSpeed(const btSolverConstraint& row, btSolverBody& first, btSolverBody& second)
{
    return AddedSpeed(Side::First(row), first) + AddedSpeed(Side::Second(row), second) - row.m_rhs / row.m_jacDiagABInv;
}

/// Velocities.
struct Impulses
{
    static constexpr bool hasFriction = true;

    static btScalar Speed(const Side& side, btSolverBody& body)
    {
        return AddedSpeed(side, body);
    }
    static btScalar Target(const btSolverConstraint& row, btSolverBody&, btSolverBody&)
    {
        return row.m_rhs / row.m_jacDiagABInv;
    }
    /// Upper bound of the target. The row has the bounce of the whole approach: of it a body has that of its own.
    static btScalar MaxTarget(const btSolverConstraint& row, const Side& side, btSolverBody& own)
    {
        const auto* point = static_cast<const btManifoldPoint*>(row.m_originalContactPoint);
        if (!(point->m_combinedRestitution > 0))
            return BT_LARGE_FLOAT;
        const btScalar approach = -StartSpeed(side, own);
        return std::max(AddedSpeed(side, own),
                        approach + point->m_combinedRestitution * std::max(approach, btScalar(0)));
    }
    /// What a body visited before adds to the speed of parting. One that comes towards the visited body counts as
    /// standing still there: it does not throw it, so that kinetic energy does not rise.
    static btScalar OtherSpeed(const Side& side, btSolverBody& other)
    {
        return std::max(AddedSpeed(side, other), -StartSpeed(side, other));
    }
    static void Apply(const Side& side, btScalar impulse, btSolverBody* body)
    {
        body->internalApplyImpulse(side.normal * body->internalGetInvMass(), side.angular, impulse);
    }
};

/// Displacements by split impulses, over the time step.
struct SplitImpulses
{
    static constexpr bool hasFriction = false;

    static btScalar Speed(const Side& side, btSolverBody& body)
    {
        return side.Along(body.internalGetPushVelocity(), body.internalGetTurnVelocity());
    }
    static btScalar Target(const btSolverConstraint& row, btSolverBody& first, btSolverBody& second)
    {
        return row.m_rhsPenetration > 0 ? row.m_rhsPenetration / row.m_jacDiagABInv
                                        : -std::max(ExcessSpeed(row, first, second), btScalar(0));
    }
    static btScalar MaxTarget(const btSolverConstraint&, const Side&, btSolverBody&)
    {
        return BT_LARGE_FLOAT;
    }
    static btScalar OtherSpeed(const Side& side, btSolverBody& other)
    {
        return Speed(side, other);
    }
    static void Apply(const Side& side, btScalar impulse, btSolverBody* body)
    {
        body->internalApplyPushImpulse(side.normal * body->internalGetInvMass(), side.angular, impulse);
    }
};

/// Friction at a contact point along one direction.
struct Friction
{
    Side side;
    btScalar target; ///< of AddedSpeed
    btScalar inverseMass;
    btScalar coefficient;
    btScalar impulse; ///< sum of all
};

/// Keeps a body from sliding, as far as the load allows. A load that has become less takes back no friction.
void Rub(btScalar load, Friction* friction, btSolverBody* own)
{
    const btScalar largest = std::max(friction->coefficient * load, btFabs(friction->impulse));
    const btScalar lack = friction->target - AddedSpeed(friction->side, *own);
    const btScalar sum = btClamped(friction->impulse + lack / friction->inverseMass, -largest, largest);
    if (sum != friction->impulse)
        Impulses::Apply(friction->side, sum - friction->impulse, own);
    friction->impulse = sum;
}
} // namespace

struct qcStackingSolver::Contact
{
    Side side;
    btScalar target; ///< least of Pass::Speed
    btScalar inverseMass;
    btScalar before;  ///< impulse of the iterations
    btScalar impulse; ///< sum of those of the present visit
    int frictionCount;
    Friction frictions[2];
};

/// Friction of a contact point along one direction, after the iterations.
struct qcStackingSolver::FrictionDef
{
    Side own, other; ///< of the visited body, and of one visited before
    btScalar target; ///< sum of AddedSpeed of both
    btScalar coefficient;
    btScalar impulse;
};

qcStackingSolver::qcStackingSolver() = default;
qcStackingSolver::~qcStackingSolver() = default;

void qcStackingSolver::reserveContacts(int points)
{
    points = std::min(points, std::numeric_limits<int>::max() / 3);
    auto reserve = [](btConstraintArray& rows, int count)
    {
        if (count <= rows.capacity())
            return;
        // Writes to the rows: the first step to use them would otherwise wait for the system's memory.
        rows.resize(count);
        rows.resizeNoInitialize(0);
    };
    // Along a normal and two directions of friction, and about them.
    reserve(m_tmpSolverContactConstraintPool, points);
    reserve(m_tmpSolverContactFrictionConstraintPool, 2 * points);
    reserve(m_tmpSolverContactRollingFrictionConstraintPool, 3 * points);
}

bool qcStackingSolver::IsFixed(int body) const
{
    const btRigidBody* original = m_tmpSolverBodyPool[body].m_originalBody;
    return original == nullptr || original->getInvMass() <= 0;
}

void qcStackingSolver::ListContacts()
{
    const size_t bodyCount = size_t(m_tmpSolverBodyPool.size());
    const int rowCount = m_tmpSolverContactConstraintPool.size();
    m_firstOf.assign(bodyCount + 1, 0);
    m_contactsOf.resize(2 * size_t(rowCount));
    auto forEachSide = [this, rowCount](auto visit)
    {
        for (int i = 0; i < rowCount; i++)
        {
            visit(m_tmpSolverContactConstraintPool[i].m_solverBodyIdA, i);
            visit(m_tmpSolverContactConstraintPool[i].m_solverBodyIdB, i);
        }
    };
    forEachSide([this](int body, int) { m_firstOf[size_t(body)]++; });
    for (size_t body = 0; body < bodyCount; body++)
        m_firstOf[body + 1] += m_firstOf[body];
    forEachSide([this](int body, int row) { m_contactsOf[size_t(--m_firstOf[size_t(body)])] = row; });
    m_firstOf[bodyCount] = 2 * rowCount;
}

/// Breadth first, from the static bodies. Fills m_order with the bodies that are reached.
void qcStackingSolver::FindLevels()
{
    constexpr int unknown = std::numeric_limits<int>::max();
    const int bodyCount = m_tmpSolverBodyPool.size();
    m_levels.assign(size_t(bodyCount), unknown);
    for (int i = 0; i < m_tmpSolverNonContactConstraintPool.size(); i++)
    {
        m_levels[size_t(m_tmpSolverNonContactConstraintPool[i].m_solverBodyIdA)] = -1;
        m_levels[size_t(m_tmpSolverNonContactConstraintPool[i].m_solverBodyIdB)] = -1;
    }
    m_order.clear();
    for (int body = 0; body < bodyCount; body++)
        if (IsFixed(body))
        {
            m_levels[size_t(body)] = 0;
            m_order.push_back(body);
        }
    const size_t fixedCount = m_order.size();
    for (size_t i = 0; i < m_order.size(); i++)
    {
        const size_t body = size_t(m_order[i]);
        for (int k = m_firstOf[body]; k < m_firstOf[body + 1]; k++)
        {
            const btSolverConstraint& row = m_tmpSolverContactConstraintPool[m_contactsOf[size_t(k)]];
            const int other = row.m_solverBodyIdA == int(body) ? row.m_solverBodyIdB : row.m_solverBodyIdA;
            if (m_levels[size_t(other)] != unknown)
                continue;
            m_levels[size_t(other)] = m_levels[body] + 1;
            m_order.push_back(other);
        }
    }
    m_order.erase(m_order.begin(), m_order.begin() + std::ptrdiff_t(fixedCount));
    std::replace(m_levels.begin(), m_levels.end(), unknown, -1);
}

/// The order of visits: by level, in each the lowest body first.
void qcStackingSolver::SortBodies()
{
    auto potential = [this](int body)
    {
        const btRigidBody& original = *m_tmpSolverBodyPool[body].m_originalBody;
        return -original.getGravity().dot(original.getWorldTransform().getOrigin());
    };
    std::stable_sort(m_order.begin(), m_order.end(),
                     [&](int a, int b) {
                         return std::make_pair(m_levels[size_t(a)], potential(a)) <
                                std::make_pair(m_levels[size_t(b)], potential(b));
                     });
    m_places.assign(m_levels.size(), -1);
    for (size_t i = 0; i < m_order.size(); i++)
        m_places[size_t(m_order[i])] = int(i);
}

/// Reads the contact points of a body with those visited before it.
template <class Pass> void qcStackingSolver::ReadContacts(int body)
{
    m_contacts.clear();
    for (int k = m_firstOf[size_t(body)]; k < m_firstOf[size_t(body) + 1]; k++)
    {
        const btSolverConstraint& row = m_tmpSolverContactConstraintPool[m_contactsOf[size_t(k)]];
        const bool isFirst = row.m_solverBodyIdA == body;
        const int other = isFirst ? row.m_solverBodyIdB : row.m_solverBodyIdA;
        if (m_levels[size_t(other)] < 0 || m_places[size_t(other)] > m_places[size_t(body)] || row.m_cfm > 0)
            continue;
        btSolverBody &first = m_tmpSolverBodyPool[row.m_solverBodyIdA],
                     &second = m_tmpSolverBodyPool[row.m_solverBodyIdB];
        const Side side = isFirst ? Side::First(row) : Side::Second(row);
        btSolverBody& own = isFirst ? first : second;
        const btScalar inverseMass = side.InverseMass(own);
        btScalar otherSpeed =
            isFirst ? Pass::OtherSpeed(Side::Second(row), second) : Pass::OtherSpeed(Side::First(row), first);
        if (IsFixed(other))
            otherSpeed = 0;
        if (inverseMass > 0)
        {
            const btScalar target =
                std::min(Pass::Target(row, first, second) - otherSpeed, Pass::MaxTarget(row, side, own));
            m_contacts.push_back({side, target, inverseMass, row.m_appliedImpulse, 0, 0, {}});
            if (Pass::hasFriction)
                ReadFrictions(m_contactsOf[size_t(k)], isFirst, &m_contacts.back());
        }
    }
}

/// Reads the rows of friction of a contact point: Bullet has them one after another. A single row has a direction that
/// turns with the speed from step to step: two directions of their own take its place, unless the application has set
/// it.
void qcStackingSolver::ReadFrictions(int row, bool isFirst, Contact* contact)
{
    const btConstraintArray& rows = m_tmpSolverContactFrictionConstraintPool;
    const btSolverConstraint& normal = m_tmpSolverContactConstraintPool[row];
    const int first = normal.m_frictionIndex;
    const auto isOfRow = [&rows, row](int index) { return index < rows.size() && rows[index].m_frictionIndex == row; };
    if (!isOfRow(first))
        return;
    const int ownIndex = isFirst ? normal.m_solverBodyIdA : normal.m_solverBodyIdB,
              otherIndex = isFirst ? normal.m_solverBodyIdB : normal.m_solverBodyIdA;
    if (isOfRow(first + 1))
    {
        for (int i = first; i < first + 2; i++)
        {
            const btSolverConstraint& friction = rows[i];
            const Side sides[2] = {Side::First(friction), Side::Second(friction)};
            const btScalar target =
                friction.m_jacDiagABInv > 0 ? friction.m_rhs / friction.m_jacDiagABInv : btScalar(0);
            AddFriction(ownIndex, otherIndex,
                        {sides[isFirst ? 0 : 1], sides[isFirst ? 1 : 0], target, friction.m_friction,
                         friction.m_appliedImpulse},
                        contact);
        }
        return;
    }
    const auto& point = *static_cast<const btManifoldPoint*>(normal.m_originalContactPoint);
    if ((point.m_contactPointFlags & BT_CONTACT_FLAG_LATERAL_FRICTION_INITIALIZED) != 0)
        return;
    const btSolverConstraint& friction = rows[first];
    const btSolverBody &own = m_tmpSolverBodyPool[ownIndex], &other = m_tmpSolverBodyPool[otherIndex];
    const btVector3 &ownPoint = isFirst ? point.getPositionWorldOnA() : point.getPositionWorldOnB(),
                    &otherPoint = isFirst ? point.getPositionWorldOnB() : point.getPositionWorldOnA();
    btVector3 directions[2];
    btPlaneSpace1(contact->side.normal, directions[0], directions[1]);
    for (const btVector3& direction : directions)
    {
        const Side ownSide = Side::At(ownPoint, direction, own), otherSide = Side::At(otherPoint, -direction, other);
        const btScalar sliding = StartSpeed(ownSide, own) + StartSpeed(otherSide, other);
        const btVector3& along = isFirst ? friction.m_contactNormal1 : friction.m_contactNormal2;
        AddFriction(
            ownIndex, otherIndex,
            {ownSide, otherSide, -sliding, friction.m_friction, friction.m_appliedImpulse * along.dot(direction)},
            contact);
    }
}

/// What slides under the visited body brakes it, and drags it no further than the iterations have: kinetic energy does
/// not rise.
void qcStackingSolver::AddFriction(int ownIndex, int otherIndex, const FrictionDef& def, Contact* contact)
{
    btSolverBody &own = m_tmpSolverBodyPool[ownIndex], &other = m_tmpSolverBodyPool[otherIndex];
    const btScalar inverseMass = def.own.InverseMass(own);
    if (!(inverseMass > 0))
        return;
    btScalar target = def.target;
    if (!IsFixed(otherIndex))
    {
        target -= AddedSpeed(def.other, other);
        const bool slides = btFabs(def.impulse) >= def.coefficient * contact->before;
        const btScalar start = StartSpeed(def.own, own), speed = start + AddedSpeed(def.own, own);
        if (slides)
            target = btClamped(target, std::min(speed, btScalar(0)) - start, std::max(speed, btScalar(0)) - start);
    }
    contact->frictions[contact->frictionCount++] = {def.own, target, inverseMass, def.coefficient, def.impulse};
}

/// Returns the change of the speed of the contact point.
template <class Pass> btScalar qcStackingSolver::Solve(Contact* contact, btSolverBody* own)
{
    const btScalar lack = contact->target - Pass::Speed(contact->side, *own);
    const btScalar sum = std::max(contact->impulse + lack / contact->inverseMass, btScalar(0));
    const btScalar impulse = sum - contact->impulse;
    if (impulse == 0)
        return 0;
    contact->impulse = sum;
    Pass::Apply(contact->side, impulse, own);
    return btFabs(impulse) * contact->inverseMass;
}

/// Stops a body against those visited before it, by projected Gauss-Seidel.
template <class Pass> void qcStackingSolver::Visit(int body)
{
    btSolverBody& own = m_tmpSolverBodyPool[body];
    ReadContacts<Pass>(body);
    btScalar first = 0;
    for (int sweep = 0; sweep < s_maxSweeps; sweep++)
    {
        btScalar largest = 0;
        for (Contact& contact : m_contacts)
            largest = std::max(largest, Solve<Pass>(&contact, &own));
        for (Contact& contact : m_contacts)
            for (int i = 0; i < contact.frictionCount; i++)
                Rub(contact.before + contact.impulse, &contact.frictions[i], &own);
        first = std::max(first, largest);
        if (largest <= s_converged * first)
            return;
    }
}

btScalar qcStackingSolver::solveGroupCacheFriendlyIterations(btCollisionObject** bodies, int bodyCount,
                                                             btPersistentManifold** manifolds, int manifoldCount,
                                                             btTypedConstraint** constraints, int constraintCount,
                                                             const btContactSolverInfo& info, btIDebugDraw* drawer)
{
    btScalar result = btSequentialImpulseConstraintSolver::solveGroupCacheFriendlyIterations(
        bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount, info, drawer);
    ListContacts();
    FindLevels();
    SortBodies();
    for (int body : m_order)
        Visit<Impulses>(body);
    if (info.m_splitImpulse)
        for (int body : m_order)
            Visit<SplitImpulses>(body);
    return result;
}
