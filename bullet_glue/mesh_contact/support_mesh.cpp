// Small meshes as their convex hulls.
#include "mesh_contact/support_mesh.h"

#include <algorithm>

namespace
{
// Vertices are compared in blocks, which compilers turn into vector instructions.
constexpr size_t s_block = 8;
// A fragment of a fracture has some hundred triangles.
constexpr size_t s_maxTriangles = 600;
// Triangles belong to a face if the cosine between their normals is more than this.
constexpr btScalar s_sameFace = btScalar(0.99999);
constexpr size_t s_maxFaces = 40;
// An edge is within a flat face if the cosine between the normals of its triangles is more than this.
constexpr btScalar s_flat = btScalar(0.9999);

/// Lists the items of each vertex. `item(i, c)`: the vertex at corner c of item i.
template <typename Item>
void MakeLists(uint32_t vertexCount, uint32_t itemCount, int corners, Item item, qcSupportMesh::Lists* lists)
{
    lists->starts.assign(vertexCount + 1, 0);
    for (uint32_t i = 0; i < itemCount; i++)
        for (int c = 0; c < corners; c++)
            lists->starts[item(i, c)]++;
    uint32_t sum = 0;
    for (uint32_t& start : lists->starts)
    {
        sum += start;
        start = sum;
    }
    lists->numbers.resize(sum);
    for (uint32_t i = itemCount; i-- > 0;)
        for (int c = corners; c-- > 0;)
            lists->numbers[--lists->starts[item(i, c)]] = i;
}
} // namespace

bool qcSupportMesh::IsSmall(size_t triangleCount)
{
    return triangleCount > 0 && triangleCount <= s_maxTriangles;
}

qcSupportMesh::qcSupportMesh(const btCollisionShape* shape) : m_triangles(shape, nullptr)
{
    size_t count = m_triangles.pointCount, padded = (count + s_block - 1) / s_block * s_block;
    for (std::vector<btScalar>* axis : {&m_x, &m_y, &m_z})
        axis->reserve(padded);
    for (size_t i = 0; i < padded; i++)
    {
        const btVector3& point = m_triangles.points[std::min(i, count - 1)];
        m_x.push_back(point.x());
        m_y.push_back(point.y());
        m_z.push_back(point.z());
        m_radius = std::max(m_radius, point.length());
    }
    FindFaces();
    FindEdges();
}

void qcSupportMesh::FindFaces()
{
    struct SizedFace
    {
        btVector3 normal; ///< of the first triangle
        btVector3 sum;    ///< of the triangles' cross products: the normal of slivers is less exact
    };
    std::vector<SizedFace> faces;
    m_normals.reserve(m_triangles.count);
    for (size_t t = 0; t < m_triangles.count; t++)
    {
        const uint32_t* index = m_triangles.indices + 3 * t;
        const btVector3* points = m_triangles.points;
        btVector3 cross = (points[index[1]] - points[index[0]]).cross(points[index[2]] - points[index[0]]);
        btScalar area = cross.length();
        m_normals.push_back(area > 0 ? cross / area : btVector3(0, 0, 0));
        if (!(area > 0))
            continue;
        const btVector3& normal = m_normals.back();
        auto same = std::find_if(faces.rbegin(), faces.rend(),
                                 [&](const SizedFace& face) { return face.normal.dot(normal) > s_sameFace; });
        if (same != faces.rend())
            same->sum += cross;
        else
            faces.push_back({normal, cross});
    }
    std::stable_sort(faces.begin(), faces.end(),
                     [](const SizedFace& a, const SizedFace& b) { return a.sum.length2() > b.sum.length2(); });
    for (size_t i = 0; i < std::min(faces.size(), s_maxFaces); i++)
    {
        btVector3 normal = faces[i].sum.normalized();
        m_faces.push_back({normal, Max(normal)});
    }
}

void qcSupportMesh::FindEdges()
{
    const uint32_t* indices = m_triangles.indices;
    MakeLists(
        m_triangles.pointCount, m_triangles.count, 3,
        [indices](uint32_t t, int c) { return indices[3 * t + uint32_t(c)]; }, &m_trianglesOf);
    for (uint32_t t = 0; t < m_triangles.count; t++)
        for (uint32_t c = 0; c < 3; c++)
        {
            uint32_t from = indices[3 * t + c], to = indices[3 * t + (c + 1) % 3];
            // The first other triangle with the edge, in either direction.
            const uint32_t* other = std::find_if(m_trianglesOf.begin(from), m_trianglesOf.end(from),
                                                 [&](uint32_t u)
                                                 {
                                                     const uint32_t* index = indices + 3 * u;
                                                     return u != t && std::find(index, index + 3, to) != index + 3;
                                                 });
            bool isShared = other != m_trianglesOf.end(from);
            if (!isShared || (t < *other && m_normals[t].dot(m_normals[*other]) < s_flat))
                m_edges.push_back({from, to, t});
        }
    MakeLists(
        m_triangles.pointCount, uint32_t(m_edges.size()), 2,
        [this](uint32_t i, int c) { return c == 0 ? m_edges[i].from : m_edges[i].to; }, &m_edgesOf);
}

btScalar qcSupportMesh::Max(const btVector3& direction) const
{
    btScalar dx = direction.x(), dy = direction.y(), dz = direction.z();
    btScalar max[s_block];
    std::fill_n(max, s_block, -BT_LARGE_FLOAT);
    const btScalar *x = m_x.data(), *y = m_y.data(), *z = m_z.data();
    for (size_t i = 0; i < m_x.size(); i += s_block)
        for (size_t lane = 0; lane < s_block; lane++)
        {
            btScalar dot = x[i + lane] * dx + y[i + lane] * dy + z[i + lane] * dz;
            max[lane] = dot > max[lane] ? dot : max[lane];
        }
    return *std::max_element(max, max + s_block);
}

uint32_t qcSupportMesh::FindMax(const btVector3& direction) const
{
    btScalar max = Max(direction);
    for (uint32_t i = 0; i < m_triangles.pointCount; i++)
        if (m_x[i] * direction.x() + m_y[i] * direction.y() + m_z[i] * direction.z() >= max)
            return i;
    return 0; // only if a coordinate is not finite
}

void qcSupportMesh::AppendNear(const btVector3& direction, btScalar depth, std::vector<uint32_t>* vertices) const
{
    btScalar least = Max(direction) - depth;
    for (uint32_t i = 0; i < m_triangles.pointCount; i++)
        if (m_x[i] * direction.x() + m_y[i] * direction.y() + m_z[i] * direction.z() >= least)
            vertices->push_back(i);
}
