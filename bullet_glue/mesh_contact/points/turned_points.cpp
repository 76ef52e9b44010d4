// Contact points of turning bodies.
#include "mesh_contact/points/turned_points.h"

#include "common/bisection.h"
#include "common/rigid_motion.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include <algorithm>
#include <cmath>

namespace
{
// Part of the contact breaking threshold: arcs that leave their lines by less in a step are lines.
constexpr btScalar s_minSagitta = btScalar(0.001);
// The cosine of 8 degrees: a point whose normal is that close to a triangle's is on its face.
constexpr btScalar s_onFace = btScalar(0.99);
// An arc is searched in parts of up to one radian.
constexpr int s_maxParts = 16;
constexpr int s_bisections = 12;

/// A body that moves by its velocities at the start of the step.
struct TurningBody
{
    qcRigidMotion motion;
    btScalar speed; ///< radians a second
    btVector3 axis{0, 0, 0};

    explicit TurningBody(const btCollisionObject* object) : motion(object), speed(motion.angular.length())
    {
        if (speed > 0)
            axis = motion.angular / speed;
    }

    btVector3 Rotated(const btVector3& vector, btScalar time) const
    {
        return speed > 0 ? vector.rotate(axis, speed * time) : vector;
    }
};

/// The path of a vertex over a face within a step.
class Arc
{
  public:
    /// `normal`: of the face. `vertex`: at the start of the step, at `distance` above it.
    Arc(const TurningBody& ofVertex, const TurningBody& ofFace, const btVector3& vertex, const btVector3& normal,
        btScalar distance)
        : m_ofVertex(ofVertex), m_ofFace(ofFace), m_arm(vertex - ofVertex.motion.centre), m_normal(normal),
          m_apart(ofVertex.motion.centre - ofFace.motion.centre),
          m_drift(ofVertex.motion.linear - ofFace.motion.linear),
          m_offset(distance - normal.dot(vertex - ofFace.motion.centre))
    {
    }

    btScalar HeightAt(btScalar time) const
    {
        return m_offset + NormalAt(time).dot(PlaceOf(ArmAt(time), time));
    }

    btScalar RiseAt(btScalar time) const
    {
        const btVector3 normal = NormalAt(time), arm = ArmAt(time);
        return m_ofFace.motion.angular.cross(normal).dot(PlaceOf(arm, time)) +
               normal.dot(m_drift + m_ofVertex.motion.angular.cross(arm));
    }

    /// From the centre of the vertex's body to the vertex, at a time, in the frame that turns with the face and is that
    /// of the world at the start.
    btVector3 ArmOnFace(btScalar time) const
    {
        return m_ofFace.Rotated(ArmAt(time), -time);
    }

    /// When the vertex touches the face, or is nearest to it, for the first time in the step. `timeStep`: it doesn't
    /// cease to sink.
    btScalar FindNearest(btScalar timeStep) const
    {
        const btScalar angle = (m_ofVertex.speed + m_ofFace.speed) * timeStep;
        const int parts = int(std::ceil(std::min(angle, btScalar(s_maxParts))));
        btScalar end = timeStep;
        for (int part = 1; part <= parts; part++)
        {
            const btScalar begin = timeStep * btScalar(part - 1) / btScalar(parts);
            end = timeStep * btScalar(part) / btScalar(parts);
            const bool rises = RiseAt(end) > 0;
            if (rises)
                end = qcBisect(begin, end, s_bisections, [this](btScalar time) { return RiseAt(time) <= 0; });
            if (HeightAt(end) < 0)
                return qcBisect(begin, end, s_bisections, [this](btScalar time) { return HeightAt(time) >= 0; });
            if (rises)
                break;
        }
        return end;
    }

  private:
    btVector3 ArmAt(btScalar time) const
    {
        return m_ofVertex.Rotated(m_arm, time);
    }

    btVector3 NormalAt(btScalar time) const
    {
        return m_ofFace.Rotated(m_normal, time);
    }

    /// From the centre of the face's body to the vertex.
    btVector3 PlaceOf(const btVector3& arm, btScalar time) const
    {
        return m_apart + m_drift * time + arm;
    }

    const TurningBody &m_ofVertex, &m_ofFace;
    btVector3 m_arm, m_normal, m_apart, m_drift;
    btScalar m_offset; ///< of heights
};

/// Finds a triangle's normal among those near one of its points.
class NormalFinder : public btTriangleCallback
{
  public:
    explicit NormalFinder(const qcTriangleSource& source) : m_source(source)
    {
    }

    void processTriangle(btVector3* triangle, int part, int index) override
    {
        if (part == m_source.part && index == m_source.index)
            normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    }

    btVector3 normal{0, 0, 0};

  private:
    qcTriangleSource m_source;
};

/// True if a contact point is on the face of its triangle, and not at an edge or a vertex, by its normal.
bool IsOnFace(const btCollisionObjectWrapper& body, const qcTriangleSource& source, const btVector3& end,
              const btVector3& normal)
{
    const btCollisionShape* shape = body.getCollisionShape();
    if (shape->getShapeType() == STATIC_PLANE_PROXYTYPE)
        return true;
    NormalFinder finder(source);
    if (const qcMeshShape* mesh = qcAsMeshShape(shape))
    {
        btVector3 triangle[3];
        for (size_t c = 0; c < 3; c++)
            triangle[c] = mesh->getVertices()[mesh->getIndices()[3 * size_t(source.index) + c]];
        finder.processTriangle(triangle, source.part, source.index);
    }
    else
    {
        // The end is on the margin.
        const btVector3 local = body.getWorldTransform().invXform(end);
        const btScalar reach = shape->getMargin() * 2 + SIMD_EPSILON;
        static_cast<const btConcaveShape*>(shape)->processAllTriangles(&finder, local - btVector3(reach, reach, reach),
                                                                       local + btVector3(reach, reach, reach));
    }
    const btVector3 world = body.getWorldTransform().getBasis() * finder.normal;
    return btFabs(world.dot(normal)) >= s_onFace * world.length();
}
} // namespace

void qcTurnPoints(const btCollisionObjectWrapper& body0, btScalar margin0, const btCollisionObjectWrapper& body1,
                  btScalar margin1, btScalar timeStep, std::vector<qcMeshPoint>* points)
{
    const TurningBody turning0(body0.getCollisionObject()), turning1(body1.getCollisionObject());
    const bool isSwapped = turning0.motion.angular.length2() < turning1.motion.angular.length2();
    const btCollisionObjectWrapper &vertexBody = isSwapped ? body1 : body0, &faceBody = isSwapped ? body0 : body1;
    const TurningBody &ofVertex = isSwapped ? turning1 : turning0, &ofFace = isSwapped ? turning0 : turning1;
    const btScalar margin = isSwapped ? margin1 : margin0; // an end on it stays below its vertex
    const btScalar minSagitta = s_minSagitta * gContactBreakingThreshold;
    const btScalar angle = ofVertex.speed * timeStep;
    const btScalar radius = vertexBody.getCollisionObject()->getCollisionShape()->getAngularMotionDisc();
    // Upper bound of what arcs leave their lines by.
    if (!(angle * angle / 2 * radius > minSagitta))
        return;
    for (qcMeshPoint& point : *points)
    {
        const btVector3 normal = isSwapped ? -point.normal : point.normal;
        btVector3 &vertex = isSwapped ? point.onB : point.onA, &foot = isSwapped ? point.onA : point.onB;
        const Arc arc(ofVertex, ofFace, vertex + normal * margin, normal, point.distance);
        const btScalar rise = arc.RiseAt(0);
        if (!(rise < 0) || !(point.distance > 0) ||
            btFabs(arc.HeightAt(timeStep) - point.distance - rise * timeStep) <= minSagitta ||
            !IsOnFace(faceBody, isSwapped ? point.sourceA : point.sourceB, foot, normal))
            continue;
        const btScalar time = arc.FindNearest(timeStep);
        const btVector3 turned = ofVertex.motion.centre + arc.ArmOnFace(time) - normal * margin;
        const btScalar solverRise = normal.dot(ofVertex.motion.VelocityAt(turned) - ofFace.motion.VelocityAt(turned));
        point.distance = arc.HeightAt(time) - time * solverRise;
        foot += turned - vertex - normal * normal.dot(turned - vertex);
        vertex = foot + normal * point.distance;
    }
}
