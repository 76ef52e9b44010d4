// Triangles of convex shapes: boxes, surfaces of revolution, and hulls of points found by the support function.
#include "soft_body/scene/convex_triangles.h"

#include "common/hull_faces.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btPolyhedralConvexShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <algorithm>
#include <cmath>

namespace
{
// The default margin of qcMeshShape, too.
constexpr btScalar s_maxMargin = btScalar(0.01);
constexpr int s_minSegments = 16, s_maxSegments = 64;
// Points of a hull by support function.
constexpr size_t s_maxPoints = 1024;
// A hull whose inner radius is a smaller share of its size is flat.
constexpr btScalar s_flat = btScalar(1e-3);
// Area of a face by the square of its length: below it the normal is not reliable.
constexpr btScalar s_thin = btScalar(1e-3);

//  ---- surfaces of revolution --------------------------------------------------------------------------------------

/// A circle around the axis; radius 0: a point on it.
struct Ring
{
    btScalar radius, height;
};

/// Segments of a circle around a circle of this radius, so that a sphere's surface of revolution is outside of the
/// sphere by at most `error`: by radius * tan^2 (pi / segments).
int SegmentsOf(btScalar radius, btScalar error)
{
    btScalar exact = SIMD_PI / std::atan(std::sqrt(error / radius));
    int fours = int(std::ceil(btClamped(exact, btScalar(s_minSegments), btScalar(s_maxSegments)) / 4));
    return 4 * fours;
}

/// The polyhedron around the surface of revolution of a profile, given from its lower end to its upper one.
void Revolve(const std::vector<Ring>& profile, int upAxis, int segments, qcConvexTriangles* triangles)
{
    std::vector<uint32_t> first;
    const btScalar outside = 1 / btCos(SIMD_PI / btScalar(segments));
    for (const Ring& ring : profile)
    {
        first.push_back(uint32_t(triangles->points.size()));
        for (int i = 0; i < (ring.radius > 0 ? segments : 1); i++)
        {
            btScalar angle = SIMD_2_PI * btScalar(i) / btScalar(segments);
            btVector3 point(0, 0, 0);
            point[upAxis] = ring.height;
            point[(upAxis + 1) % 3] = ring.radius * outside * btCos(angle);
            point[(upAxis + 2) % 3] = ring.radius * outside * btSin(angle);
            triangles->points.push_back(point);
        }
    }
    for (size_t r = 0; r + 1 < profile.size(); r++)
        for (uint32_t i = 0; i < uint32_t(segments); i++)
        {
            uint32_t next = (i + 1) % uint32_t(segments);
            bool isLowerPoint = profile[r].radius <= 0, isUpperPoint = profile[r + 1].radius <= 0;
            uint32_t a = first[r] + (isLowerPoint ? 0 : i), b = first[r] + next;
            uint32_t c = first[r + 1] + (isUpperPoint ? 0 : next), d = first[r + 1] + i;
            if (!isLowerPoint)
                triangles->indices.insert(triangles->indices.end(), {a, b, c});
            if (!isUpperPoint)
                triangles->indices.insert(triangles->indices.end(), {a, c, d});
        }
}

/// A sphere pulled apart along its axis: both hemispheres are polygons around their meridians.
void MakeCapsule(btScalar radius, btScalar halfHeight, int upAxis, qcConvexTriangles* triangles)
{
    const int segments = SegmentsOf(radius, triangles->margin / 2), half = segments / 2;
    const btScalar outer = radius / btCos(SIMD_PI / btScalar(segments));
    std::vector<Ring> profile;
    for (int i = 0; i <= half; i++)
    {
        btScalar angle = SIMD_PI * btScalar(i) / btScalar(half) - SIMD_HALF_PI;
        btScalar height = outer * btSin(angle);
        bool isPole = i == 0 || i == half;
        if (2 * i <= half)
            profile.push_back({isPole ? 0 : outer * btCos(angle), height - halfHeight});
        if (2 * i > half || (2 * i == half && halfHeight > 0))
            profile.push_back({isPole ? 0 : outer * btCos(angle), height + halfHeight});
    }
    Revolve(profile, upAxis, segments, triangles);
}

//  ---- boxes -------------------------------------------------------------------------------------------------------

void MakeBox(const btVector3& half, qcConvexTriangles* triangles)
{
    for (int i = 0; i < 8; i++)
        triangles->points.push_back(btVector3((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                                              (i & 4) != 0 ? half.z() : -half.z()));
    triangles->indices = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                          2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
}

//  ---- hulls -------------------------------------------------------------------------------------------------------

/// A convex body by its support function: a shape without its margin or with it, enlarged by a ball.
struct Support
{
    const btConvexShape* shape;
    bool hasMargin;
    btScalar ball;

    btVector3 operator()(const btVector3& direction) const
    {
        btVector3 point = hasMargin ? shape->localGetSupportingVertex(direction)
                                    : shape->localGetSupportingVertexWithoutMargin(direction);
        return point + direction * ball;
    }
};

/// A face of a hull: a plane, and its corners.
struct Face
{
    btVector3 normal; ///< unit, outward; see NormalOf
    btScalar level;   ///< min of normal . corner
    std::vector<uint32_t> corners;
};

/// Zero for a face too thin to have a reliable one.
btVector3 NormalOf(const std::vector<btVector3>& points, const std::vector<uint32_t>& corners)
{
    btVector3 normal(0, 0, 0);
    btScalar longest2 = 0;
    for (size_t i = 1; i + 1 < corners.size(); i++)
    {
        const btVector3 first = points[corners[i]] - points[corners[0]];
        const btVector3 second = points[corners[i + 1]] - points[corners[0]];
        normal += first.cross(second);
        longest2 = std::max(longest2, std::max(first.length2(), second.length2()));
    }
    btScalar length = normal.length();
    return length > s_thin * longest2 ? normal / length : btVector3(0, 0, 0);
}

/// The hull's faces, with corners among the points given: btConvexHullComputer rounds its own to a grid.
std::vector<Face> FacesOf(const std::vector<btVector3>& points)
{
    btConvexHullComputer hull;
    hull.compute(&points[0].x(), int(sizeof(btVector3)), int(points.size()), 0, 0);
    std::vector<Face> faces;
    for (int f = 0; f < hull.faces.size(); f++)
    {
        Face face;
        for (uint32_t corner : qcCornersOfFace(hull, f))
            face.corners.push_back(uint32_t(hull.original_vertex_index[int(corner)]));
        face.normal = NormalOf(points, face.corners);
        face.level = BT_LARGE_FLOAT;
        for (uint32_t corner : face.corners)
            face.level = std::min(face.level, face.normal.dot(points[corner]));
        faces.push_back(std::move(face));
    }
    return faces;
}

btVector3 CenterOf(const std::vector<btVector3>& points)
{
    btVector3 sum(0, 0, 0);
    for (const btVector3& point : points)
        sum += point;
    return sum / btScalar(points.size());
}

/// True if the faces enclose a volume around the center.
bool IsSolid(const std::vector<Face>& faces, const btVector3& center, btScalar size)
{
    return faces.size() >= 4 &&
           std::all_of(faces.begin(), faces.end(),
                       [&](const Face& face)
                       { return face.normal.isZero() || face.level - face.normal.dot(center) > s_flat * size; });
}

/// Adds a point of the body in each direction in which it is outside of the hull by more than `error`. False: none.
bool Refine(const Support& support, const std::vector<Face>& faces, btScalar error, std::vector<btVector3>* points)
{
    size_t count = points->size();
    for (const Face& face : faces)
    {
        if (face.normal.isZero())
            continue;
        btVector3 point = support(face.normal);
        if (face.normal.dot(point) > face.level + error && points->size() < s_maxPoints &&
            std::find(points->begin(), points->end(), point) == points->end())
            points->push_back(point);
    }
    return points->size() > count;
}

/// Scales the points about the center until the hull contains the shape, if it doesn't yet.
void Enclose(Support support, const std::vector<Face>& faces, const btVector3& center, std::vector<btVector3>* points)
{
    support.ball = 0;
    btScalar scale = 1;
    for (const Face& face : faces)
        scale =
            std::max(scale, face.normal.dot(support(face.normal) - center) / (face.level - face.normal.dot(center)));
    for (btVector3& point : *points)
        point = center + (point - center) * scale;
}

void AddFaces(const std::vector<Face>& faces, const std::vector<btVector3>& points, qcConvexTriangles* triangles)
{
    triangles->points = points;
    for (const Face& face : faces)
        qcAddTriangles(face.corners, &triangles->indices);
}

/// The hull of points of the body. If it comes within the radius of the body's ball in all directions, it contains the
/// shape. False: it is flat.
bool MakeHull(const Support& support, btScalar size, qcConvexTriangles* triangles)
{
    std::vector<btVector3> points = qcOutermostPoints(support);
    std::vector<Face> faces = FacesOf(points);
    while (Refine(support, faces, support.ball, &points))
        faces = FacesOf(points);
    btVector3 center = CenterOf(points);
    if (!IsSolid(faces, center, size))
        return false;
    Enclose(support, faces, center, &points);
    AddFaces(faces, points, triangles);
    return true;
}

/// The hull of a polyhedron's corners, exactly. False: it is flat, or they are not known.
bool MakePolyhedron(const btConvexShape* shape, btScalar size, qcConvexTriangles* triangles)
{
    const auto* polyhedron = dynamic_cast<const btPolyhedralConvexShape*>(shape);
    std::vector<btVector3> points(polyhedron != nullptr ? size_t(polyhedron->getNumVertices()) : 0);
    for (size_t i = 0; i < points.size(); i++)
        polyhedron->getVertex(int(i), points[i]);
    if (points.size() < 4)
        return false;
    std::vector<Face> faces = FacesOf(points);
    if (!IsSolid(faces, CenterOf(points), size))
        return false;
    AddFaces(faces, points, triangles);
    return true;
}

/// Any other shape. A flat one is thickened.
bool MakeAny(const btConvexShape* shape, btScalar size, qcConvexTriangles* triangles)
{
    const bool isPolyhedron = shape->isPolyhedral();
    const btScalar error = std::max(triangles->margin / 2, size / 200);
    return (isPolyhedron && MakePolyhedron(shape, size, triangles)) ||
           MakeHull({shape, !isPolyhedron, error}, size, triangles) ||
           MakeHull({shape, true, size / 50}, size, triangles);
}

void MakeCylinder(const btCylinderShape& cylinder, qcConvexTriangles* triangles)
{
    const int up = cylinder.getUpAxis();
    const btScalar half = cylinder.getHalfExtentsWithMargin()[up], radius = cylinder.getRadius();
    Revolve({{0, -half}, {radius, -half}, {radius, half}, {0, half}}, up, SegmentsOf(radius, triangles->margin / 2),
            triangles);
}

void MakeCone(const btConeShape& cone, qcConvexTriangles* triangles)
{
    const btScalar half = cone.getHeight() / 2, radius = cone.getRadius();
    Revolve({{0, -half}, {radius, -half}, {0, half}}, cone.getConeUpIndex(), SegmentsOf(radius, triangles->margin / 2),
            triangles);
}
} // namespace

bool qcMakeConvexTriangles(const btConvexShape* shape, qcConvexTriangles* triangles)
{
    *triangles = qcConvexTriangles();
    btVector3 lower, upper;
    shape->getAabb(btTransform::getIdentity(), lower, upper);
    const btVector3 extent = (upper - lower) / 2;
    const btScalar largest = extent[extent.maxAxis()], smallest = std::max(extent[extent.minAxis()], largest / 100);
    if (!(largest > 0) || !std::isfinite(lower.dot(upper)))
        return false;
    const int type = shape->getShapeType();
    const bool isMarginOutside = (shape->isPolyhedral() && type != BOX_SHAPE_PROXYTYPE) || type == CONE_SHAPE_PROXYTYPE;
    triangles->margin =
        std::max(std::min(s_maxMargin, smallest / 8), isMarginOutside ? shape->getMargin() : btScalar(0));
    if (type == BOX_SHAPE_PROXYTYPE)
        MakeBox(static_cast<const btBoxShape*>(shape)->getHalfExtentsWithMargin(), triangles);
    else if (type == SPHERE_SHAPE_PROXYTYPE)
        MakeCapsule(static_cast<const btSphereShape*>(shape)->getRadius(), 0, 1, triangles);
    else if (type == CAPSULE_SHAPE_PROXYTYPE)
    {
        const auto* capsule = static_cast<const btCapsuleShape*>(shape);
        MakeCapsule(capsule->getRadius(), capsule->getHalfHeight(), capsule->getUpAxis(), triangles);
    }
    else if (type == CYLINDER_SHAPE_PROXYTYPE)
        MakeCylinder(*static_cast<const btCylinderShape*>(shape), triangles);
    else if (type == CONE_SHAPE_PROXYTYPE)
        MakeCone(*static_cast<const btConeShape*>(shape), triangles);
    else
        return MakeAny(shape, largest, triangles);
    return true;
}
