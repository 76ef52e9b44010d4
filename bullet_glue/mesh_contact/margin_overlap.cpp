// Margins that overlap when a contact begins.
#include "mesh_contact/margin_overlap.h"

#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <algorithm>

namespace
{
// Part of the margins that give way in a second. Pieces of a cube of 2 m with margins of 10 mm then leave each other at
// 0.07 m/s at most, in place of 0.74 m/s.
constexpr btScalar s_rate = 1;

/// Upper bound of the motion of an object's points in a step.
btScalar MaxTravel(const btCollisionObject* object, btScalar timeStep)
{
    return qcRigidMotion(object).MaxSpeed(object->getCollisionShape()->getAngularMotionDisc()) * timeStep;
}
} // namespace

void qcMarginOverlap::Apply(const btCollisionObject* object0, const btCollisionObject* object1, btScalar margins,
                            btScalar timeStep, std::vector<qcMeshPoint>* points)
{
    if (timeStep <= 0)
        return;
    bool begins = !m_hasBegun;
    m_hasBegun = true;
    if (!begins && m_rest <= 0)
        return;
    btScalar overlap = 0;
    for (const qcMeshPoint& point : *points)
        overlap = std::max(overlap, -point.distance);
    overlap = std::min(overlap, margins);
    if (begins)
        m_rest = MaxTravel(object0, timeStep) + MaxTravel(object1, timeStep) <= margins ? overlap : btScalar(0);
    else
        m_rest = std::min(std::max(m_rest - s_rate * margins * timeStep, btScalar(0)), overlap);
    for (qcMeshPoint& point : *points)
        point.distance += m_rest;
}
