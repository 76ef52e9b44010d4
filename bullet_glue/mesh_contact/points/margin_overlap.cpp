// Margins that overlap when a contact begins.
#include "mesh_contact/points/margin_overlap.h"

#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <algorithm>

namespace
{
// Part of the margins that give way in a second. test_margin_overlap prints the speeds, which would be eight to
// twelve times as high.
constexpr btScalar s_rate = 1;

/// Upper bound of the motion of an object's points in a step; large if it is unknown.
btScalar MaxTravel(const btCollisionObject* object, btScalar timeStep)
{
    return qcMaxClosingDistance(object, object->getCollisionShape()->getAngularMotionDisc(), timeStep, BT_LARGE_FLOAT,
                                qcRigidMotion());
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
        m_rest = overlap > 0 && MaxTravel(object0, timeStep) + MaxTravel(object1, timeStep) <= margins ? overlap
                                                                                                       : btScalar(0);
    else
        m_rest = std::min(std::max(m_rest - s_rate * margins * timeStep, btScalar(0)), overlap);
    for (qcMeshPoint& point : *points)
        point.distance += m_rest;
}
