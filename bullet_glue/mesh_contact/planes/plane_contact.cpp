// Contact of two meshes on both sides of a plane.
#include "mesh_contact/planes/plane_contact.h"

#include <algorithm>

namespace
{
// Triangles and edges that rise more steeply than this cosine from the plane are seen as lines and points.
constexpr btScalar s_steepFace = btScalar(0.3), s_steepEdge = btScalar(0.7);
// A mesh of more vertices is read only where it overlaps the other one: to find that costs as much as some vertices.
constexpr uint32_t s_maxWhole = 64;

/// Which triangles are over a place along the plane, and at what heights.
struct Heights
{
    decltype(qcLanes() < qcLanes()) isOver;
    qcLanes height;

    Heights(const qcFlatSimplices<3>::Block& triangles, const qcFlat& place)
    {
        qcLanes weights[3], sum{};
        for (size_t c = 0; c < 3; c++)
        {
            const size_t p = (c + 1) % 3, q = (c + 2) % 3;
            weights[c] = (triangles.u[p] - place.u) * (triangles.v[q] - place.v) -
                         (triangles.v[p] - place.v) * (triangles.u[q] - place.u);
            sum += weights[c];
        }
        isOver = ((sum > 0) & (weights[0] >= 0) & (weights[1] >= 0) & (weights[2] >= 0)) |
                 ((sum < 0) & (weights[0] <= 0) & (weights[1] <= 0) & (weights[2] <= 0));
        height =
            (weights[0] * triangles.height[0] + weights[1] * triangles.height[1] + weights[2] * triangles.height[2]) /
            (isOver ? sum : qcLanes{} + 1);
    }
};

/// Which edges cross an edge of A, as seen along the axis, and where.
struct Crossings
{
    decltype(qcLanes() < qcLanes()) cross;
    qcLanes partA;   ///< of the edge of A
    qcLanes heightB; ///< of the other edge there

    Crossings(const qcFlatSimplices<2>::Block& edges, const qcFlat& from, const qcFlat& to)
    {
        const btScalar pu = to.u - from.u, pv = to.v - from.v;
        const qcLanes qu = edges.u[1] - edges.u[0], qv = edges.v[1] - edges.v[0];
        const qcLanes du = edges.u[0] - from.u, dv = edges.v[0] - from.v;
        const qcLanes area = pu * qv - pv * qu, divisor = area != 0 ? area : qcLanes{} + 1;
        partA = (du * qv - dv * qu) / divisor;
        const qcLanes partB = (du * pv - dv * pu) / divisor;
        cross = (area != 0) & (partA >= 0) & (partA <= 1) & (partB >= 0) & (partB <= 1);
        heightB = edges.height[0] + partB * (edges.height[1] - edges.height[0]);
    }
};

/// A triangle with all of these vertices; the count of triangles if there is none.
uint32_t FindTriangle(const qcSupportMesh& mesh, const uint32_t* corners, int count)
{
    const qcMeshTriangles& triangles = mesh.Triangles();
    for (const uint32_t* t = mesh.TrianglesOf().begin(corners[0]); t != mesh.TrianglesOf().end(corners[0]); t++)
    {
        const uint32_t* index = triangles.indices + 3 * size_t(*t);
        if (std::all_of(corners, corners + count,
                        [index](uint32_t corner) { return std::find(index, index + 3, corner) != index + 3; }))
            return *t;
    }
    return triangles.count;
}
} // namespace

template <size_t count> bool qcPlaneContact::Extent::Overlaps(const qcFlat (&corners)[count]) const
{
    auto [lowU, highU] =
        std::minmax_element(corners, corners + count, [](const qcFlat& x, const qcFlat& y) { return x.u < y.u; });
    auto [lowV, highV] =
        std::minmax_element(corners, corners + count, [](const qcFlat& x, const qcFlat& y) { return x.v < y.v; });
    return Overlaps(lowU->u, highU->u, lowV->v, highV->v);
}

qcPlaneContact::Extent qcPlaneContact::ExtentOf(const qcPlacedSupport& placed) const
{
    Extent extent;
    const btVector3 from = placed.transform.getOrigin() - m_origin;
    for (int axis = 0; axis < 2; axis++)
    {
        const btVector3& direction = axis == 0 ? m_u : m_v;
        extent.lower[axis] = from.dot(direction) - placed.mesh->Max(placed.ToLocal(-direction)) - m_slack;
        extent.upper[axis] = from.dot(direction) + placed.mesh->Max(placed.ToLocal(direction)) + m_slack;
    }
    return extent;
}

/// Finds the runs of vertices with triangles that may lie where the other mesh is.
void qcPlaneContact::FindRuns(const qcSupportMesh& mesh, const View& view, Side* side)
{
    side->runs.clear();
    const btVector3 u = view.u.absolute(), v = view.v.absolute();
    const std::vector<qcSupportMesh::Box>& boxes = mesh.BoxesOfRuns();
    for (size_t run = 0; run < boxes.size(); run++)
    {
        const btVector3 half = (boxes[run].upper - boxes[run].lower) / 2;
        const qcFlat centre = view((boxes[run].lower + boxes[run].upper) / 2);
        const btScalar halfU = u.dot(half), halfV = v.dot(half);
        if (side->other.Overlaps(centre.u - halfU, centre.u + halfU, centre.v - halfV, centre.v + halfV))
            side->runs.push_back(run);
    }
}

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
        if (!isFirst)
            continue;
        const qcFlat corners[] = {view(all.points[index[0]]), view(all.points[index[1]]), view(all.points[index[2]])};
        if (side->other.Overlaps(corners))
            side->triangles.Add(corners, *t);
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
        if (!(rise * rise <= s_steepEdge * s_steepEdge * along.length2()))
            continue;
        const qcFlat ends[] = {view(points[edge.from]), view(points[edge.to])};
        if (side->other.Overlaps(ends))
            side->edges.Add(ends, edge.triangle);
    }
}

/// Reads what of a mesh is at most `thickness` from its outermost vertex, and lies where the other mesh is.
void qcPlaneContact::Read(const qcPlacedSupport& placed, const qcPlacedSupport& other, const btVector3& outward,
                          btScalar thickness, Side* side) const
{
    const qcSupportMesh& mesh = *placed.mesh;
    const bool isLarge = mesh.Triangles().pointCount > s_maxWhole;
    constexpr btScalar all = BT_LARGE_FLOAT;
    side->other = isLarge ? ExtentOf(other) : Extent{{-all, -all}, {all, all}};
    btVector3 from = placed.transform.getOrigin() - m_origin;
    View view{placed.ToLocal(m_u), placed.ToLocal(m_v), placed.ToLocal(m_axis),
              btVector3(from.dot(m_u), from.dot(m_v), from.dot(m_axis))};
    side->vertices.clear();
    side->triangles.Clear();
    side->edges.Clear();
    side->near.clear();
    btVector3 local = placed.ToLocal(outward);
    const btScalar level = mesh.Max(local) - thickness;
    FindRuns(mesh, view, side);
    if (mesh.Vertices().RunCount() > 0)
        mesh.Vertices().AppendAboveInRuns(local, level, side->runs, &side->near);
    else
        mesh.Vertices().AppendAbove(local, level, &side->near);
    if (side->isNear.size() < mesh.Triangles().pointCount)
        side->isNear.resize(mesh.Triangles().pointCount);
    for (uint32_t vertex : side->near)
        side->isNear[vertex] = 1;
    for (uint32_t vertex : side->near)
    {
        const qcFlat place[] = {view(mesh.Triangles().points[vertex])};
        if (side->other.Overlaps(place) && mesh.TrianglesOf().begin(vertex) != mesh.TrianglesOf().end(vertex))
            side->vertices.push_back({place[0], *mesh.TrianglesOf().begin(vertex)});
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
    point.sourceA = qcSourceOf(m_trianglesA->sources, triangleA);
    point.sourceB = qcSourceOf(m_trianglesB->sources, triangleB);
    m_points.push_back(point);
}

/// Adds the vertices of one side that lie over the other.
void qcPlaneContact::AddVertices(const Side& vertices, const Triangles& triangles, bool ofA)
{
    for (const Vertex& vertex : vertices.vertices)
    {
        // The layer next to the plane: the first triangle of those with the same height.
        uint32_t nearest = UINT32_MAX;
        qcFlat below = vertex.place;
        auto [block, end] = triangles.FindBlocks(vertex.place.u - m_slack, vertex.place.u + m_slack);
        for (; block < end; block++)
        {
            const Heights heights(triangles.At(block), vertex.place);
            if (!qcIsAny(heights.isOver))
                continue;
            for (size_t lane = 0; lane < qcLaneCount; lane++)
            {
                if (heights.isOver[lane] == 0)
                    continue;
                const uint32_t number = triangles.NumberAt(block, lane);
                const btScalar height = heights.height[lane];
                const bool isNearer = ofA ? height < below.height : height > below.height;
                if (nearest != UINT32_MAX && !isNearer && !(height == below.height && number < nearest))
                    continue;
                nearest = number;
                below.height = height;
            }
        }
        if (nearest == UINT32_MAX)
            continue;
        if (ofA)
            AddPoint(vertex.place, below, vertex.triangle, triangles.TriangleOf(nearest));
        else
            AddPoint(below, vertex.place, triangles.TriangleOf(nearest), vertex.triangle);
    }
}

/// Adds the places where an edge of A crosses edges of B, as seen along the axis.
void qcPlaneContact::AddCrossings(const qcFlat& from, const qcFlat& to, uint32_t triangle, const Edges& edges)
{
    m_crossings.clear();
    auto [block, end] = edges.FindBlocks(std::min(from.u, to.u) - m_slack, std::max(from.u, to.u) + m_slack);
    for (; block < end; block++)
    {
        const Crossings crossings(edges.At(block), from, to);
        if (!qcIsAny(crossings.cross))
            continue;
        for (size_t lane = 0; lane < qcLaneCount; lane++)
            if (crossings.cross[lane] != 0)
                m_crossings.push_back({edges.NumberAt(block, lane), crossings.partA[lane], crossings.heightB[lane]});
    }
    std::sort(m_crossings.begin(), m_crossings.end(),
              [](const Crossing& x, const Crossing& y) { return x.number < y.number; });
    for (const Crossing& crossing : m_crossings)
    {
        const btScalar part = crossing.partA;
        qcFlat onA{from.u + part * (to.u - from.u), from.v + part * (to.v - from.v),
                   from.height + part * (to.height - from.height)};
        AddPoint(onA, {onA.u, onA.v, crossing.heightB}, triangle, edges.TriangleOf(crossing.number));
    }
}

/// Adds the closest points of the hulls if they are points of the meshes. False: they are not.
bool qcPlaneContact::AddClosest(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation)
{
    if (separation.cornerCount == 0)
        return false;
    uint32_t triangleA = FindTriangle(*a.mesh, separation.cornersA, separation.cornerCount);
    uint32_t triangleB = FindTriangle(*b.mesh, separation.cornersB, separation.cornerCount);
    if (triangleA == a.mesh->Triangles().count || triangleB == b.mesh->Triangles().count)
        return false;
    btVector3 apart = separation.onA - separation.onB;
    m_points.push_back({separation.onA, separation.onB, apart.normalized(), apart.length(),
                        qcSourceOf(m_trianglesA->sources, triangleA), qcSourceOf(m_trianglesB->sources, triangleB)});
    return true;
}

void qcPlaneContact::AddTouching(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation,
                                 std::vector<qcMeshPoint>* points)
{
    auto sourceOf = [](const qcSupportMesh& mesh, uint32_t vertex)
    { return qcSourceOf(mesh.Triangles().sources, *mesh.TrianglesOf().begin(vertex)); };
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
    Read(a, b, m_axis, thickness, &m_a);
    Read(b, a, -m_axis, thickness, &m_b);
    m_a.triangles.Sort();
    m_b.triangles.Sort();
    m_b.edges.Sort();
    AddVertices(m_a, m_b.triangles, true);
    AddVertices(m_b, m_a.triangles, false);
    for (uint32_t edge = 0; edge < m_a.edges.Count(); edge++)
        AddCrossings(m_a.edges.CornerAt(edge, 0), m_a.edges.CornerAt(edge, 1), m_a.edges.TriangleOf(edge), m_b.edges);
    if (m_points.empty() && !(orClosest && AddClosest(a, b, separation)))
        return false;
    points->insert(points->end(), m_points.begin(), m_points.end());
    return true;
}
