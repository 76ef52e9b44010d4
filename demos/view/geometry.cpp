// Triangles of Bullet's shapes: meshes have theirs, convex shapes those of a hull around points of their surface.
#include "view/geometry.h"

#include "quickcullide/bullet_mesh.h"

#include <BulletCollision/CollisionShapes/btShapeHull.h>
#include <BulletSoftBody/btSoftBody.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace
{
constexpr float s_planeHalfWidth = 60;
constexpr btScalar s_crease = btScalar(0.8); // cosine of the angle above which an edge is sharp

void AddPoint(const btVector3& point, qcViewTriangles* triangles)
{
    for (int axis = 0; axis < 3; axis++)
        triangles->positions.push_back(float(point[axis]));
}

btVector3 PointAt(const qcViewTriangles& triangles, uint32_t vertex)
{
    const float* p = &triangles.positions[3 * size_t(vertex)];
    return btVector3(p[0], p[1], p[2]);
}

class TriangleCollector : public btTriangleCallback
{
  public:
    explicit TriangleCollector(qcViewTriangles* triangles) : m_triangles(triangles)
    {
    }
    void processTriangle(btVector3* corners, int, int) override
    {
        for (int c = 0; c < 3; c++)
        {
            m_triangles->indices.push_back(uint32_t(m_triangles->positions.size() / 3));
            AddPoint(corners[c], m_triangles);
        }
    }

  private:
    qcViewTriangles* m_triangles;
};

void AddPlane(const btStaticPlaneShape& plane, qcViewTriangles* triangles)
{
    btVector3 u, v, middle = plane.getPlaneNormal() * plane.getPlaneConstant();
    btPlaneSpace1(plane.getPlaneNormal(), u, v);
    for (const btVector3& corner : {-u - v, u - v, u + v, v - u})
        AddPoint(middle + corner * btScalar(s_planeHalfWidth), triangles);
    bool isFront = u.cross(v).dot(plane.getPlaneNormal()) > 0;
    triangles->indices = isFront ? std::vector<uint32_t>{0, 1, 2, 0, 2, 3} : std::vector<uint32_t>{0, 2, 1, 0, 3, 2};
}

/// A round shape as a mesh of rings: radius and height of each from the bottom up.
void AddRings(const std::vector<std::pair<btScalar, btScalar>>& rings, int upAxis, qcViewTriangles* triangles)
{
    constexpr uint32_t segments = 64;
    for (const auto& [radius, height] : rings)
        for (uint32_t i = 0; i < segments; i++)
        {
            btScalar angle = SIMD_2_PI * btScalar(i) / segments;
            btVector3 point;
            point[upAxis] = height;
            point[(upAxis + 1) % 3] = radius * std::cos(angle);
            point[(upAxis + 2) % 3] = radius * std::sin(angle);
            AddPoint(point, triangles);
        }
    for (uint32_t ring = 0; ring + 1 < rings.size(); ring++)
        for (uint32_t i = 0; i < segments; i++)
        {
            uint32_t a = ring * segments + i, b = ring * segments + (i + 1) % segments;
            triangles->indices.insert(triangles->indices.end(), {a, b, b + segments, a, b + segments, a + segments});
        }
}

void AddCylinder(const btCylinderShape& cylinder, qcViewTriangles* triangles)
{
    btVector3 half = cylinder.getHalfExtentsWithMargin();
    int up = cylinder.getUpAxis();
    btScalar radius = cylinder.getRadius(), height = half[up];
    AddRings({{0, -height}, {radius, -height}, {radius, height}, {0, height}}, up, triangles);
}

void AddSphere(btScalar radius, qcViewTriangles* triangles)
{
    std::vector<std::pair<btScalar, btScalar>> rings;
    for (int i = 0; i <= 32; i++)
        rings.emplace_back(radius * std::sin(SIMD_PI * btScalar(i) / 32),
                           -radius * std::cos(SIMD_PI * btScalar(i) / 32));
    AddRings(rings, 1, triangles);
}

void AddConvex(const btConvexShape& shape, qcViewTriangles* triangles)
{
    btShapeHull hull(&shape);
    if (!hull.buildHull(shape.getMargin(), 1))
        return;
    for (int i = 0; i < hull.numVertices(); i++)
        AddPoint(hull.getVertexPointer()[i], triangles);
    triangles->indices.assign(hull.getIndexPointer(), hull.getIndexPointer() + hull.numIndices());
}

void AddMesh(const qcMeshShape& mesh, qcViewTriangles* triangles)
{
    for (uint32_t v = 0; v < mesh.getVertexCount(); v++)
        AddPoint(mesh.getVertices()[v], triangles);
    triangles->indices.assign(mesh.getIndices(), mesh.getIndices() + 3 * size_t(mesh.getTriangleCount()));
}

void Fill(const btCollisionShape* shape, qcViewTriangles* triangles)
{
    if (auto* mesh = dynamic_cast<const qcMeshShape*>(shape))
        AddMesh(*mesh, triangles);
    else if (shape->getShapeType() == STATIC_PLANE_PROXYTYPE)
        AddPlane(*static_cast<const btStaticPlaneShape*>(shape), triangles);
    else if (shape->getShapeType() == CYLINDER_SHAPE_PROXYTYPE)
        AddCylinder(*static_cast<const btCylinderShape*>(shape), triangles);
    else if (shape->getShapeType() == SPHERE_SHAPE_PROXYTYPE)
        AddSphere(static_cast<const btSphereShape*>(shape)->getRadius(), triangles);
    else if (shape->isConvex())
        AddConvex(*static_cast<const btConvexShape*>(shape), triangles);
    else if (shape->isConcave())
    {
        TriangleCollector collector(triangles);
        const btVector3 far(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
        static_cast<const btConcaveShape*>(shape)->processAllTriangles(&collector, -far, far);
    }
}

/// Fills the shaded vertices: normals are averaged over the triangles around a vertex whose angle is below that of a
/// crease; `smooth`: over all of them.
void Shade(bool smooth, qcViewTriangles* triangles)
{
    size_t count = triangles->indices.size() / 3, vertices = triangles->positions.size() / 3;
    std::vector<btVector3> areas(count);
    std::vector<uint32_t> first(vertices + 1), around(3 * count);
    for (size_t t = 0; t < count; t++)
    {
        const uint32_t* index = &triangles->indices[3 * t];
        btVector3 a = PointAt(*triangles, index[0]);
        areas[t] = (PointAt(*triangles, index[1]) - a).cross(PointAt(*triangles, index[2]) - a);
        for (int c = 0; c < 3; c++)
            first[index[c] + 1]++;
    }
    for (size_t v = 0; v < vertices; v++)
        first[v + 1] += first[v];
    std::vector<uint32_t> next(first.begin(), first.end() - 1);
    for (size_t corner = 0; corner < 3 * count; corner++)
        around[next[triangles->indices[corner]]++] = uint32_t(corner / 3);
    triangles->shaded.resize(3 * count);
    for (size_t corner = 0; corner < 3 * count; corner++)
    {
        uint32_t vertex = triangles->indices[corner];
        const btVector3& own = areas[corner / 3];
        btVector3 normal(0, 0, 0);
        for (uint32_t i = first[vertex]; i < first[vertex + 1]; i++)
        {
            const btVector3& other = areas[around[i]];
            if (smooth || own.dot(other) >= s_crease * std::sqrt(own.length2() * other.length2()))
                normal += other;
        }
        btScalar length = normal.length();
        normal = length > 0 ? normal / length : btVector3(0, 1, 0);
        qcShadedVertex& shaded = triangles->shaded[corner];
        for (int axis = 0; axis < 3; axis++)
        {
            shaded.position[axis] = triangles->positions[3 * size_t(vertex) + size_t(axis)];
            shaded.normal[axis] = float(normal[axis]);
        }
    }
}
} // namespace

bool qcViewGeometry::Known::operator<(const Known& other) const
{
    auto key = [](const Known& k)
    { return std::make_tuple(k.shape, k.type, k.revision, k.scaling.x(), k.scaling.y(), k.scaling.z()); };
    return key(*this) < key(other);
}

void qcViewGeometry::Clear()
{
    m_known.clear();
    m_numbers.clear();
    m_surfaces.clear();
    m_nextNumber = 0;
}

std::shared_ptr<qcViewTriangles> qcViewGeometry::Find(const Known& known, bool* isNew)
{
    std::shared_ptr<qcViewTriangles>& used = m_used[known];
    if (used == nullptr)
    {
        auto found = m_known.find(known);
        if (found != m_known.end())
            used = found->second;
    }
    *isNew = used == nullptr;
    if (*isNew)
    {
        used = std::make_shared<qcViewTriangles>();
        used->id = ++m_nextId;
    }
    return used;
}

void qcViewGeometry::AddShape(const btCollisionObject* object, uint32_t number, const btCollisionShape* shape,
                              const btTransform& place)
{
    if (shape->isCompound())
    {
        const auto& compound = *static_cast<const btCompoundShape*>(shape);
        for (int i = 0; i < compound.getNumChildShapes(); i++)
            AddShape(object, number, compound.getChildShape(i), place * compound.getChildTransform(i));
        return;
    }
    auto* mesh = dynamic_cast<const qcMeshShape*>(shape);
    bool isNew;
    qcViewSurface surface;
    surface.object = object;
    surface.number = number;
    surface.place = place;
    surface.unbounded = shape->getShapeType() == STATIC_PLANE_PROXYTYPE;
    surface.triangles = Find(
        {shape, shape->getShapeType(), mesh != nullptr ? mesh->getRevision() : 0, shape->getLocalScaling()}, &isNew);
    if (isNew)
    {
        Fill(shape, surface.triangles.get());
        Shade(false, surface.triangles.get());
    }
    m_surfaces.push_back(surface);
}

void qcViewGeometry::AddSoftBody(const btSoftBody* body, uint32_t number)
{
    bool isNew;
    qcViewSurface surface;
    surface.object = body;
    surface.number = number;
    surface.deforming = true;
    surface.triangles =
        Find({body, SOFTBODY_SHAPE_PROXYTYPE, uint64_t(body->m_faces.size()), btVector3(1, 1, 1)}, &isNew);
    qcViewTriangles& triangles = *surface.triangles;
    if (isNew)
        for (int i = 0; i < body->m_faces.size(); i++)
            for (const btSoftBody::Node* node : body->m_faces[i].m_n)
                triangles.indices.push_back(uint32_t(node - &body->m_nodes[0]));
    triangles.positions.clear();
    for (int i = 0; i < body->m_nodes.size(); i++)
        AddPoint(body->m_nodes[i].m_x, &triangles);
    triangles.changes++;
    Shade(true, &triangles);
    m_surfaces.push_back(surface);
}

void qcViewGeometry::AddBounds(const btCollisionObject* object)
{
    const btBroadphaseProxy* proxy = object->getBroadphaseHandle();
    const btVector3 &lower = proxy->m_aabbMin, &upper = proxy->m_aabbMax;
    if (!((upper - lower).length() < 1000)) // a plane, or a body that has fallen without end
        return;
    bool isFirst = m_lower.x() > m_upper.x();
    m_lower = isFirst ? lower
                      : btVector3(std::min(m_lower.x(), lower.x()), std::min(m_lower.y(), lower.y()),
                                  std::min(m_lower.z(), lower.z()));
    m_upper = isFirst ? upper
                      : btVector3(std::max(m_upper.x(), upper.x()), std::max(m_upper.y(), upper.y()),
                                  std::max(m_upper.z(), upper.z()));
}

void qcViewGeometry::Update(const btCollisionWorld& world)
{
    m_surfaces.clear();
    m_used.clear();
    m_lower = btVector3(1, 1, 1);
    m_upper = btVector3(-1, -1, -1);
    std::map<std::pair<const btCollisionObject*, int>, uint32_t> numbers;
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        const btCollisionObject* object = objects[i];
        auto key = std::make_pair(object, object->getBroadphaseHandle()->m_uniqueId);
        auto found = m_numbers.find(key);
        uint32_t number = numbers[key] = found != m_numbers.end() ? found->second : m_nextNumber++;
        if (const btSoftBody* body = btSoftBody::upcast(object))
            AddSoftBody(body, number);
        else
            AddShape(object, number, object->getCollisionShape(), object->getWorldTransform());
        AddBounds(object);
    }
    if (m_lower.x() > m_upper.x())
    {
        m_lower = btVector3(-1, -1, -1);
        m_upper = btVector3(1, 1, 1);
    }
    m_numbers.swap(numbers);
    m_known.swap(m_used);
}
