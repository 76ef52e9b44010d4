// Contact of two meshes on both sides of a plane.
#include "mesh_contact/plane_contact.h"

#include <algorithm>

namespace
{
// Triangles and edges that rise more steeply than this cosine from the plane are seen as lines and points.
constexpr btScalar s_steepFace = btScalar(0.3), s_steepEdge = btScalar(0.7);

qcTriangleSource SourceIn(const qcMeshTriangles& triangles, uint32_t triangle)
{
    return triangles.sources.empty() ? qcTriangleSource{0, int(triangle)} : triangles.sources[triangle];
}

/// A triangle with all of these vertices; the count of triangles if there is none.
uint32_t FindTriangle(const qcMeshTriangles& triangles, const uint32_t* corners, int count)
{
    for (uint32_t t = 0; t < triangles.count; t++)
    {
        const uint32_t* index = triangles.indices + 3 * size_t(t);
        if (std::all_of(corners, corners + count,
                        [index](uint32_t corner) { return std::find(index, index + 3, corner) != index + 3; }))
            return t;
    }
    return triangles.count;
}
} // namespace

/// Reads the triangles of a vertex, but steep ones; each at its first vertex next to the plane.
void qcPlaneContact::ReadTriangles(const qcSupportMesh& mesh, const View& view, uint32_t vertex, Side* side)
{
    const qcMeshTriangles& all = mesh.Triangles();
    for (const uint32_t* t = mesh.TrianglesOf().begin(vertex); t != mesh.TrianglesOf().end(vertex); t++)
    {
        if (!(btFabs(mesh.Normals()[*t].dot(view.height)) > s_steepFace))
            continue;
        const uint32_t* index = all.indices + 3 * size_t(*t);
        bool isFirst = std::none_of(index, index + 3,
                                    [&](uint32_t corner) { return corner < vertex && side->isNear[corner] != 0; });
        if (isFirst)
            side->triangles.push_back(
                {{view(all.points[index[0]]), view(all.points[index[1]]), view(all.points[index[2]])}, *t});
    }
}

/// Reads the edges of a vertex, but steep ones; each at its first vertex next to the plane.
void qcPlaneContact::ReadEdges(const qcSupportMesh& mesh, const View& view, uint32_t vertex, Side* side)
{
    const btVector3* points = mesh.Triangles().points;
    for (const uint32_t* e = mesh.EdgesOf().begin(vertex); e != mesh.EdgesOf().end(vertex); e++)
    {
        const qcSupportMesh::Edge& edge = mesh.Edges()[*e];
        uint32_t other = edge.from == vertex ? edge.to : edge.from;
        if (other < vertex && side->isNear[other] != 0)
            continue;
        btVector3 along = points[edge.to] - points[edge.from];
        btScalar rise = along.dot(view.height);
        if (rise * rise <= s_steepEdge * s_steepEdge * along.length2())
            side->edges.push_back({view(points[edge.from]), view(points[edge.to]), edge.triangle});
    }
}

/// Reads what of a mesh is at most `thickness` from its outermost vertex.
void qcPlaneContact::Read(const qcPlacedSupport& placed, const btVector3& outward, btScalar thickness, Side* side) const
{
    const qcSupportMesh& mesh = *placed.mesh;
    btVector3 from = placed.transform.getOrigin() - m_origin;
    View view{placed.ToLocal(m_u), placed.ToLocal(m_v), placed.ToLocal(m_axis),
              btVector3(from.dot(m_u), from.dot(m_v), from.dot(m_axis))};
    side->vertices.clear();
    side->triangles.clear();
    side->edges.clear();
    side->near.clear();
    btVector3 local = placed.ToLocal(outward);
    mesh.AppendAbove(local, mesh.Max(local) - thickness, &side->near);
    if (side->isNear.size() < mesh.Triangles().pointCount)
        side->isNear.resize(mesh.Triangles().pointCount);
    for (uint32_t vertex : side->near)
        side->isNear[vertex] = 1;
    for (uint32_t vertex : side->near)
    {
        if (mesh.TrianglesOf().begin(vertex) != mesh.TrianglesOf().end(vertex))
            side->vertices.push_back({view(mesh.Triangles().points[vertex]), *mesh.TrianglesOf().begin(vertex)});
        ReadTriangles(mesh, view, vertex, side);
        ReadEdges(mesh, view, vertex, side);
    }
    for (uint32_t vertex : side->near)
        side->isNear[vertex] = 0;
}

void qcPlaneContact::AddPoint(const qcFlat& onA, const qcFlat& onB, uint32_t triangleA, uint32_t triangleB)
{
    btScalar distance = onB.height - onA.height;
    if (!(distance <= m_distance))
        return;
    qcMeshPoint point;
    btVector3 foot = m_origin + m_u * onA.u + m_v * onA.v;
    point.onA = foot + m_axis * onA.height;
    point.onB = foot + m_axis * onB.height;
    point.normal = -m_axis;
    point.distance = distance;
    point.sourceA = SourceIn(*m_trianglesA, triangleA);
    point.sourceB = SourceIn(*m_trianglesB, triangleB);
    m_points.push_back(point);
}

/// The height of a triangle at a place along the plane. False: the place is beside the triangle.
bool qcPlaneContact::FindHeight(const Triangle& triangle, const qcFlat& place, btScalar* height)
{
    btScalar weights[3], sum = 0;
    for (int c = 0; c < 3; c++)
    {
        const qcFlat &p = triangle.corners[(c + 1) % 3], &q = triangle.corners[(c + 2) % 3];
        weights[c] = (p.u - place.u) * (q.v - place.v) - (p.v - place.v) * (q.u - place.u);
        sum += weights[c];
    }
    bool inside = sum > 0 ? weights[0] >= 0 && weights[1] >= 0 && weights[2] >= 0
                          : sum < 0 && weights[0] <= 0 && weights[1] <= 0 && weights[2] <= 0;
    if (inside)
        *height = (weights[0] * triangle.corners[0].height + weights[1] * triangle.corners[1].height +
                   weights[2] * triangle.corners[2].height) /
                  sum;
    return inside;
}

void qcFlatBoxes::Clear()
{
    m_boxes.clear();
    m_widest = 0;
}

void qcFlatBoxes::Add(std::initializer_list<qcFlat> corners)
{
    qcFlatBox box(corners);
    box.number = uint32_t(m_boxes.size());
    m_widest = std::max(m_widest, box.highU - box.lowU);
    m_boxes.push_back(box);
}

void qcFlatBoxes::Sort()
{
    std::sort(m_boxes.begin(), m_boxes.end(), [](const qcFlatBox& a, const qcFlatBox& b) { return a.lowU < b.lowU; });
}

const std::vector<uint32_t>& qcFlatBoxes::FindNear(const qcFlatBox& box, btScalar slack)
{
    m_found.clear();
    auto isBefore = [](const qcFlatBox& some, btScalar u) { return some.lowU < u; };
    auto near = std::lower_bound(m_boxes.begin(), m_boxes.end(), box.lowU - slack - m_widest, isBefore);
    for (; near != m_boxes.end() && near->lowU <= box.highU + slack; ++near)
        if (near->highU >= box.lowU - slack && near->lowV <= box.highV + slack && near->highV >= box.lowV - slack)
            m_found.push_back(near->number);
    std::sort(m_found.begin(), m_found.end());
    return m_found;
}

/// Adds the vertices of one side that lie over the other.
void qcPlaneContact::AddVertices(const Side& vertices, const Side& triangles, bool ofA)
{
    m_boxes.Clear();
    for (const Triangle& triangle : triangles.triangles)
        m_boxes.Add({triangle.corners[0], triangle.corners[1], triangle.corners[2]});
    m_boxes.Sort();
    for (const Vertex& vertex : vertices.vertices)
    {
        // The layer next to the plane.
        const Triangle* nearest = nullptr;
        qcFlat below = vertex.place;
        for (uint32_t number : m_boxes.FindNear({vertex.place}, m_slack))
        {
            const Triangle& triangle = triangles.triangles[number];
            btScalar height;
            if (!FindHeight(triangle, vertex.place, &height) ||
                (nearest != nullptr && (ofA ? height >= below.height : height <= below.height)))
                continue;
            nearest = &triangle;
            below.height = height;
        }
        if (nearest != nullptr && ofA)
            AddPoint(vertex.place, below, vertex.triangle, nearest->index);
        else if (nearest != nullptr)
            AddPoint(below, vertex.place, nearest->index, vertex.triangle);
    }
}

/// Adds the place where two edges cross, as seen along the axis.
void qcPlaneContact::AddCrossing(const Edge& p, const Edge& q)
{
    btScalar pu = p.to.u - p.from.u, pv = p.to.v - p.from.v, qu = q.to.u - q.from.u, qv = q.to.v - q.from.v;
    btScalar cross = pu * qv - pv * qu, du = q.from.u - p.from.u, dv = q.from.v - p.from.v;
    if (cross == 0)
        return;
    btScalar s = (du * qv - dv * qu) / cross, t = (du * pv - dv * pu) / cross;
    if (!(s >= 0 && s <= 1 && t >= 0 && t <= 1))
        return;
    qcFlat onA{p.from.u + s * pu, p.from.v + s * pv, p.from.height + s * (p.to.height - p.from.height)};
    qcFlat onB = onA;
    onB.height = q.from.height + t * (q.to.height - q.from.height);
    AddPoint(onA, onB, p.triangle, q.triangle);
}

/// Adds the places where edges of both sides cross.
void qcPlaneContact::AddCrossings()
{
    m_boxes.Clear();
    for (const Edge& edge : m_b.edges)
        m_boxes.Add({edge.from, edge.to});
    m_boxes.Sort();
    for (const Edge& edge : m_a.edges)
        for (uint32_t number : m_boxes.FindNear({edge.from, edge.to}, m_slack))
            AddCrossing(edge, m_b.edges[number]);
}

/// Adds the closest points of the hulls if they are points of the meshes. False: they are not.
bool qcPlaneContact::AddClosest(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation)
{
    if (separation.cornerCount == 0)
        return false;
    uint32_t triangleA = FindTriangle(*m_trianglesA, separation.cornersA, separation.cornerCount);
    uint32_t triangleB = FindTriangle(*m_trianglesB, separation.cornersB, separation.cornerCount);
    if (triangleA == a.mesh->Triangles().count || triangleB == b.mesh->Triangles().count)
        return false;
    btVector3 apart = separation.onA - separation.onB;
    m_points.push_back({separation.onA, separation.onB, apart.normalized(), apart.length(),
                        SourceIn(*m_trianglesA, triangleA), SourceIn(*m_trianglesB, triangleB)});
    return true;
}

void qcPlaneContact::AddTouching(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation,
                                 std::vector<qcMeshPoint>* points)
{
    auto sourceOf = [](const qcSupportMesh& mesh, uint32_t vertex)
    { return SourceIn(mesh.Triangles(), *mesh.TrianglesOf().begin(vertex)); };
    for (int i = 0; i < separation.cornerCount; i++)
    {
        btVector3 onA = a.VertexAt(separation.cornersA[i]), onB = b.VertexAt(separation.cornersB[i]);
        btScalar distance = separation.axis.dot(onB - onA);
        points->push_back({onA, onA + separation.axis * distance, -separation.axis, distance,
                           sourceOf(*a.mesh, separation.cornersA[i]), sourceOf(*b.mesh, separation.cornersB[i])});
        points->back().isFaceCorner = true;
    }
}

bool qcPlaneContact::Find(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation,
                          btScalar distance, bool orClosest, std::vector<qcMeshPoint>* points)
{
    m_axis = separation.axis;
    btPlaneSpace1(m_axis, m_u, m_v);
    m_origin = a.transform.getOrigin();
    m_distance = distance;
    m_slack = qcGapError(a, b);
    m_trianglesA = &a.mesh->Triangles();
    m_trianglesB = &b.mesh->Triangles();
    m_points.clear();
    btScalar thickness = distance - separation.gap;
    Read(a, m_axis, thickness, &m_a);
    Read(b, -m_axis, thickness, &m_b);
    AddVertices(m_a, m_b, true);
    AddVertices(m_b, m_a, false);
    AddCrossings();
    if (m_points.empty() && !(orClosest && AddClosest(a, b, separation)))
        return false;
    points->insert(points->end(), m_points.begin(), m_points.end());
    return true;
}
