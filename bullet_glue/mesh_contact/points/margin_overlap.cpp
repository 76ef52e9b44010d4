// Margins that overlap when a contact begins.
#include "mesh_contact/points/margin_overlap.h"

#include "common/object_motion.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>

namespace
{
// Part of the margins that give way in a second. test_margin_overlap prints the speeds, which would be eight to
// twelve times as high.
constexpr btScalar s_rate = 1;

bool HasKnownMotion(const btCollisionObject* object)
{
    return qcIsStatic(object) || btRigidBody::upcast(object) != nullptr;
}

/// True if the bodies pass each other by no more than this in a step where they overlap. The pieces of a body that has
/// just broken don't, however fast it was.
bool AreSlow(const btCollisionObject* object0, const btCollisionObject* object1, btScalar distance, btScalar timeStep,
             const std::vector<qcMeshPoint>& points)
{
    if (!HasKnownMotion(object0) || !HasKnownMotion(object1))
        return false;
    const qcRigidMotion motion0(object0), motion1(object1);
    return std::all_of(points.begin(), points.end(),
                       [&](const qcMeshPoint& point)
                       {
                           const btVector3 velocity = motion1.VelocityAt(point.onB) - motion0.VelocityAt(point.onA);
                           return point.distance >= 0 || velocity.length() * timeStep <= distance;
                       });
}
} // namespace

void qcMarginOverlap::Apply(const btCollisionObject* object0, const btCollisionObject* object1, btScalar margins,
                            btScalar timeStep, std::vector<qcMeshPoint>* points)
{
    bool begins = !m_hasBegun;
    m_hasBegun = true;
    btScalar overlap = 0;
    for (const qcMeshPoint& point : *points)
        overlap = std::max(overlap, -point.distance);
    overlap = std::min(overlap, margins);
    if (begins)
        m_rest = overlap > 0 && AreSlow(object0, object1, margins, timeStep, *points) ? overlap : btScalar(0);
    else
        m_rest = std::min(std::max(m_rest - s_rate * margins * timeStep, btScalar(0)), overlap);
    for (qcMeshPoint& point : *points)
        point.distance += m_rest;
}
