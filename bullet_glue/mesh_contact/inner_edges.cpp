// Contact points at inner edges: left out, or straightened.
#include "mesh_contact/inner_edges.h"

#include "common/rigid_motion.h"
#include "common/shape_triangles.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

namespace
{
// Normals within this cosine of the face's are not slanted.
constexpr btScalar s_straight = btScalar(0.9999);
// A triangle contains a point that is no further from it than this share of the size of the one that was hit; it leads
// nearer if a corner is nearer by more than that and by this share of its distance.
constexpr btScalar s_slack = btScalar(1e-3);
// Below this cosine a normal is along the triangle, and the side is that of the centre of the convex shape.
constexpr btScalar s_minCosine = btScalar(0.1);
// A face is what supports directions that are tilted by this from its normal, which is more than the error of Bullet's
// normals, if it is larger than this share of the convex shape.
constexpr btScalar s_faceTilt = btScalar(0.03), s_faceShare = btScalar(0.1);
// Normals of more than this cosine may be the same, but for Bullet's errors.
constexpr btScalar s_sameNormal = btScalar(0.995);

/// True if a convex shape has a face with this outward normal, in world space.
bool HasFace(const btCollisionObjectWrapper& convex, const btVector3& normal)
{
    const auto& shape = *static_cast<const btConvexShape*>(convex.getCollisionShape());
    const btMatrix3x3& basis = convex.getWorldTransform().getBasis();
    btVector3 axes[2];
    btPlaneSpace1(normal, axes[0], axes[1]);
    btVector3 ends[4];
    for (int i = 0; i < 4; i++)
        ends[i] = shape.localGetSupportingVertex((normal + axes[i % 2] * (i < 2 ? s_faceTilt : -s_faceTilt)) * basis);
    btVector3 lower, upper;
    shape.getAabb(btTransform::getIdentity(), lower, upper);
    const btScalar area = (ends[0] - ends[2]).cross(ends[1] - ends[3]).length();
    return area > s_faceShare * s_faceShare * (upper - lower).length2();
}

btVector3 ClosestOn(const btVector3 corners[3], const btVector3& point)
{
    btSubSimplexClosestResult found;
    found.reset();
    btVoronoiSimplexSolver().closestPtPointTriangle(point, corners[0], corners[1], corners[2], found);
    return found.m_closestPointOnSimplex;
}

/// The direction without what leads from a triangle's closest point to its corners: no way within it leads nearer.
/// Bullet's normals are off by up to some hundredths, which at a ridge that a flat face lies on would count as a slope
/// along it.
btVector3 WithoutWaysWithin(const btVector3 corners[3], const btVector3& closest, const btVector3& direction)
{
    btVector3 left = direction;
    for (int i = 0; i < 6; i++)
    {
        const btVector3 way = corners[i % 3] - closest;
        const btScalar along = way.dot(left);
        if (along > 0)
            left -= way * (along / way.length2());
    }
    return left.length2() > SIMD_EPSILON ? left.normalized() : direction;
}

/// Looks for triangles around a point into which the way leads nearer to what is outward.
struct NearerTriangle : btTriangleCallback
{
    const int without; ///< index of the triangle that was hit
    const btVector3 &point, &outward;
    const btScalar slack;
    btVector3 normal{0, 0, 0};     ///< unit, of the one that faces outward most, on either side; zero: there is none
    btScalar faces = btScalar(-1); ///< absolute cosine of the angle between normal and outward

    NearerTriangle(int hit, const btVector3& around, const btVector3& away, btScalar ofSize)
        : without(hit), point(around), outward(away), slack(s_slack * ofSize)
    {
    }

    void processTriangle(btVector3* corners, int part, int index) override
    {
        (void)part;
        if (index == without || ClosestOn(corners, point).distance(point) > slack)
            return;
        bool leadsNearer = false;
        for (int i = 0; i < 3; i++)
        {
            const btVector3 way = corners[i] - point;
            leadsNearer = leadsNearer || way.dot(outward) > slack + s_slack * way.length();
        }
        const btVector3 across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        if (!leadsNearer || !(across.length2() > 0))
            return;
        const btVector3 unit = across.normalized();
        if (btFabs(unit.dot(outward)) <= faces)
            return;
        normal = unit;
        faces = btFabs(unit.dot(outward));
    }
};

/// Looks for a triangle with this normal, on either side, around a point.
struct TriangleOfPlane : btTriangleCallback
{
    const btVector3 &normal, &point;
    const btScalar slack;
    bool isFound = false;

    TriangleOfPlane(const btVector3& ofPlane, const btVector3& around, btScalar within)
        : normal(ofPlane), point(around), slack(within)
    {
    }

    void processTriangle(btVector3* corners, int part, int index) override
    {
        (void)part, (void)index;
        const btVector3 across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        isFound = isFound || (btFabs(across.dot(normal)) > s_straight * across.length() &&
                              ClosestOn(corners, point).distance(point) <= slack);
    }
};
} // namespace

qcInnerEdgeFilter::qcInnerEdgeFilter(const btCollisionObjectWrapper& mesh, const btCollisionObjectWrapper& convex,
                                     Points points, btManifoldResult* result)
    : btManifoldResult(result->getBody0Wrap(), result->getBody1Wrap()),
      m_mesh(*qcAsMeshShape(mesh.getCollisionShape())), m_place(mesh.getWorldTransform()), m_meshBody(mesh),
      m_convexBody(convex), m_center(m_place.invXform(convex.getWorldTransform().getOrigin())), m_points(points),
      m_result(result)
{
    m_closestPointDistanceThreshold = result->m_closestPointDistanceThreshold;
    m_manifoldPtr = result->getPersistentManifold();
}

qcInnerEdgeFilter::~qcInnerEdgeFilter()
{
    m_result->setPersistentManifold(m_manifoldPtr);
}

void qcInnerEdgeFilter::setShapeIdentifiersA(int part, int index)
{
    m_triangle = index;
    m_result->setShapeIdentifiersA(part, index);
}

void qcInnerEdgeFilter::setShapeIdentifiersB(int part, int index)
{
    m_triangle = index;
    m_result->setShapeIdentifiersB(part, index);
}

bool qcInnerEdgeFilter::IsPassed(const btVector3& normal, const btVector3& point) const
{
    if (m_points == Points::all)
        return true;
    const bool recedes = qcRecession(m_convexBody.getCollisionObject(), point, normal, 1, BT_LARGE_FLOAT) > 0 ||
                         qcRecession(m_meshBody.getCollisionObject(), point, -normal, 1, BT_LARGE_FLOAT) > 0;
    return recedes == (m_points == Points::receding);
}

/// The normal of a triangle around this one's point that leads nearer to what is outward, towards the convex shape;
/// zero: none does.
btVector3 qcInnerEdgeFilter::NearerNormal(const btVector3 corners[3], const btVector3& point, const btVector3& outward,
                                          btScalar size) const
{
    const btVector3 closest = ClosestOn(corners, point);
    const btVector3 away = WithoutWaysWithin(corners, closest, outward);
    NearerTriangle nearer(m_triangle, closest, away, size);
    const btVector3 reach(nearer.slack, nearer.slack, nearer.slack);
    m_mesh.processAllTriangles(&nearer, closest - reach, closest + reach);
    const btScalar side = nearer.normal.dot(nearer.faces > s_minCosine ? away : m_center - closest);
    return side < 0 ? -nearer.normal : nearer.normal;
}

/// True if the mesh is flat from a point on it to where the convex shape is lowest along this normal: no ridge is
/// between the two, which would carry the shape.
bool qcInnerEdgeFilter::IsFlatUnder(const btVector3& normal, const btVector3& point, btScalar size) const
{
    const btTransform& place = m_convexBody.getWorldTransform();
    const btVector3 down = m_place.getBasis() * -normal;
    const auto& shape = *static_cast<const btConvexShape*>(m_convexBody.getCollisionShape());
    const btVector3 lowest = m_place.invXform(place * shape.localGetSupportingVertex(down * place.getBasis()));
    const btVector3 foot = lowest - normal * normal.dot(lowest - point);
    TriangleOfPlane triangle(normal, foot, s_slack * size);
    const btVector3 reach(triangle.slack, triangle.slack, triangle.slack);
    m_mesh.processAllTriangles(&triangle, foot - reach, foot + reach);
    return triangle.isFound;
}

void qcInnerEdgeFilter::addContactPoint(const btVector3& normal, const btVector3& point, btScalar distance)
{
    if (!IsPassed(normal, point))
        return;
    btVector3 passed = normal;
    // A large depth along one normal is no measure of the depth along another one.
    const bool isDeep = distance < -m_manifoldPtr->getContactBreakingThreshold();
    if (m_triangle >= 0 && uint32_t(m_triangle) < m_mesh.getTriangleCount() && !isDeep)
    {
        const uint32_t* index = m_mesh.getIndices() + 3 * size_t(m_triangle);
        const btVector3* vertices = m_mesh.getVertices();
        const btVector3 corners[3] = {vertices[index[0]], vertices[index[1]], vertices[index[2]]};
        const btVector3 across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        const btVector3 outward = m_place.getBasis().transpose() * normal;
        const btScalar area = across.length(), cosine = across.dot(outward) / area;
        // Triangles without area have no normal, and a cosine that is not a number.
        const btVector3 nearer = btFabs(cosine) < s_straight
                                     ? NearerNormal(corners, m_place.invXform(point), outward, btSqrt(area))
                                     : btVector3(0, 0, 0);
        if (!nearer.isZero())
        {
            if (distance > 0)
                return;
            // A face that lies on a ridge has sunk in along its own normal, beside the ridge as on it.
            if (nearer.dot(outward) > s_sameNormal || !HasFace(m_convexBody, -normal) ||
                IsFlatUnder(nearer, ClosestOn(corners, m_place.invXform(point)), btSqrt(area)))
                passed = m_place.getBasis() * nearer;
        }
    }
    // Callbacks see what Bullet's algorithm has set.
    const btCollisionObjectWrapper *body0 = m_result->getBody0Wrap(), *body1 = m_result->getBody1Wrap();
    m_result->setPersistentManifold(m_manifoldPtr);
    m_result->setBody0Wrap(getBody0Wrap());
    m_result->setBody1Wrap(getBody1Wrap());
    m_result->addContactPoint(passed, point, distance);
    m_result->setBody0Wrap(body0);
    m_result->setBody1Wrap(body1);
}
