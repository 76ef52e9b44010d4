// Small meshes as their convex hulls.
#include "common/support_mesh.h"

#include <algorithm>
#include <cstring>

namespace
{
// A fragment of a fracture has some hundred triangles, a fine one thousands, and a plane between it and the next: with
// up to 600, 31 pieces of a bunny of 69 666 triangles take 2.7 s for their first step, and 0.02 s with this. Bunnies of
// 69 666 triangles are seldom separated, and take a seventh more (qc-bench piles).
constexpr size_t s_maxTriangles = 16384;
// Triangles belong to a face if the cosine between their normals is more than this.
constexpr btScalar s_sameFace = btScalar(0.99999);
constexpr size_t s_maxFaces = 40;
// A mesh counts as convex if its vertices are above its triangles by at most this part of its radius.
constexpr btScalar s_maxBump = 32 * SIMD_EPSILON;
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

struct SizedFace
{
    btVector3 normal; ///< of the first triangle
    btVector3 sum;    ///< of the triangles' cross products: the normal of slivers is less exact
};

/// The faces of a mesh by the first coordinate of their normals: those of one face lie in the same bin or the next.
class FaceBins
{
  public:
    /// The last face with nearly this normal; the count of faces if there is none.
    uint32_t FindLast(const std::vector<SizedFace>& faces, const btVector3& normal) const
    {
        uint32_t last = uint32_t(faces.size());
        size_t bin = BinOf(normal);
        for (size_t near = bin - 1; near <= bin + 1; near++)
            for (size_t i = m_bins[near].size(); i-- > 0;)
            {
                uint32_t face = m_bins[near][i];
                if (last < faces.size() && face < last)
                    break;
                if (faces[face].normal.dot(normal) > s_sameFace)
                {
                    last = face;
                    break;
                }
            }
        return last;
    }

    void Add(uint32_t face, const btVector3& normal)
    {
        m_bins[BinOf(normal)].push_back(face);
    }

  private:
    // Normals of one face differ by at most sqrt(2 - 2 * s_sameFace) = 0.0045 in each coordinate.
    static constexpr size_t s_bins = 400;

    /// From 1 to s_bins; 1 for a normal that is not a number.
    static size_t BinOf(const btVector3& normal)
    {
        return 1 + std::min(size_t(std::max(btScalar(0), (normal.x() + 1) / 2) * s_bins), s_bins - 1);
    }

    std::vector<uint32_t> m_bins[s_bins + 2];
};
} // namespace

bool qcSupportMesh::IsSmall(size_t triangleCount)
{
    return triangleCount > 0 && triangleCount <= s_maxTriangles;
}

qcSupportMesh::qcSupportMesh(const btCollisionShape* shape)
    : m_triangles(shape, nullptr), m_vertices(m_triangles.points, m_triangles.pointCount)
{
    for (size_t i = 0; i < m_triangles.pointCount; i++)
        m_radius = std::max(m_radius, m_triangles.points[i].length());
    MakeLists(
        m_triangles.pointCount, m_triangles.count, 3,
        [this](uint32_t t, int c) { return m_triangles.indices[3 * t + uint32_t(c)]; }, &m_trianglesOf);
    FindFaces();
    FindBoxesOfRuns();
}

void qcSupportMesh::FindBoxesOfRuns()
{
    const btVector3* points = m_triangles.points;
    for (size_t run = 0; run < m_vertices.RunCount(); run++)
    {
        const btVector3 far(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
        Box box{far, -far};
        auto include = [&](uint32_t vertex)
        {
            box.lower.setMin(points[vertex]);
            box.upper.setMax(points[vertex]);
        };
        auto includeTriangles = [&](uint32_t vertex)
        {
            include(vertex);
            for (const uint32_t* t = m_trianglesOf.begin(vertex); t != m_trianglesOf.end(vertex); t++)
                std::for_each(m_triangles.indices + 3 * size_t(*t), m_triangles.indices + 3 * (size_t(*t) + 1),
                              include);
        };
        m_vertices.ForEachInRun(run, includeTriangles);
        m_boxesOfRuns.push_back(box);
    }
}

bool qcSupportMesh::IsConvex() const
{
    std::call_once(m_convexityOnce, [this] { m_isConvex = FindIsConvex(); });
    return m_isConvex;
}

bool qcSupportMesh::FindIsConvex() const
{
    for (size_t t = 0; t < m_triangles.count; t++)
    {
        const btVector3& corner = m_triangles.points[m_triangles.indices[3 * t]];
        if (!m_normals[t].fuzzyZero() && Max(m_normals[t]) > m_normals[t].dot(corner) + s_maxBump * m_radius)
            return false;
    }
    return true;
}

void qcSupportMesh::FindFaces()
{
    std::vector<SizedFace> faces;
    FaceBins bins;
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
        uint32_t same = bins.FindLast(faces, normal);
        if (same < faces.size())
        {
            faces[same].sum += cross;
            continue;
        }
        bins.Add(uint32_t(faces.size()), normal);
        faces.push_back({normal, cross});
    }
    std::stable_sort(faces.begin(), faces.end(),
                     [](const SizedFace& a, const SizedFace& b) { return a.sum.length2() > b.sum.length2(); });
    for (size_t i = 0; i < std::min(faces.size(), s_maxFaces); i++)
    {
        btVector3 normal = faces[i].sum.normalized();
        m_faces.push_back({normal, Max(normal)});
    }
    m_facesByMax = m_faces;
    std::stable_sort(m_facesByMax.begin(), m_facesByMax.end(),
                     [](const Face& a, const Face& b) { return a.max < b.max; });
}

qcSupportMesh::EdgeLists qcSupportMesh::FindEdges() const
{
    EdgeLists made;
    const uint32_t* indices = m_triangles.indices;
    for (uint32_t t = 0; t < m_triangles.count; t++)
        for (uint32_t c = 0; c < 3; c++)
        {
            uint32_t from = indices[3 * t + c], to = indices[3 * t + (c + 1) % 3];
            // The first other triangle with the edge, in either direction.
            const uint32_t* other =
                std::find_if(m_trianglesOf.begin(from), m_trianglesOf.end(from),
                             [&](uint32_t u)
                             {
                                 const uint32_t* index = indices + 3 * u;
                                 return u != t && (index[0] == to || index[1] == to || index[2] == to);
                             });
            bool isShared = other != m_trianglesOf.end(from);
            if (!isShared || (t < *other && m_normals[t].dot(m_normals[*other]) < s_flat))
                made.edges.push_back({from, to, t});
        }
    MakeLists(
        m_triangles.pointCount, uint32_t(made.edges.size()), 2,
        [&made](uint32_t i, int c) { return c == 0 ? made.edges[i].from : made.edges[i].to; }, &made.edgesOf);
    return made;
}

const qcSupportMesh::EdgeLists& qcSupportMesh::KeepEdges() const
{
    std::lock_guard<std::mutex> lock(m_edgesMutex);
    if (m_edges == nullptr)
        m_edges.reset(new EdgeLists(FindEdges()));
    m_foundEdges.store(m_edges.get(), std::memory_order_release);
    return *m_edges;
}
