// Each face is a chain of edges that ends nowhere: where it leaves the plane's inside it comes back as often. An edge
// of each such place to another closes it again, and all those edges together bound the new face. So whatever rounding
// did to the points, all stays closed. Which place is joined to which makes no difference to what edges cover of the
// line in which the face meets the plane; next to next, none lie on each other.
#include "fracture/plane_clip.h"

#include "fracture/triangulate_face.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace
{
constexpr uint32_t s_none = UINT32_MAX;

//  ---- edges of a mesh -------------------------------------------------------------------------------

/// An edge as one triangle passes it.
struct Pass
{
    uint32_t high;
    bool isDownward; ///< to the point with the lower number
    uint32_t triangle;

    bool operator<(const Pass& other) const
    {
        return std::tie(high, isDownward, triangle) < std::tie(other.high, other.isDownward, other.triangle);
    }
};

/// Passes by the lower point; `ends` of those of each.
std::vector<Pass> SortPasses(const qcClipMesh& mesh, std::vector<size_t>* ends)
{
    std::vector<Pass> passes(3 * mesh.triangles.size());
    ends->assign(mesh.points.size() + 1, 0);
    for (const qcClipTriangle& triangle : mesh.triangles)
        for (size_t c = 0; c < 3; c++)
            (*ends)[std::min(triangle.corner[c], triangle.corner[(c + 1) % 3]) + 1]++;
    for (size_t i = 1; i < ends->size(); i++)
        (*ends)[i] += (*ends)[i - 1];
    for (size_t i = 0; i < mesh.triangles.size(); i++)
        for (size_t c = 0; c < 3; c++)
        {
            uint32_t from = mesh.triangles[i].corner[c], to = mesh.triangles[i].corner[(c + 1) % 3];
            passes[(*ends)[std::min(from, to)]++] = {std::max(from, to), from > to, uint32_t(i)};
        }
    ends->pop_back();
    size_t first = 0;
    for (size_t end : *ends)
    {
        std::sort(passes.begin() + std::ptrdiff_t(first), passes.begin() + std::ptrdiff_t(end));
        first = end;
    }
    return passes;
}

/// Two triangles back to back hold nothing between them: drops them. Whether there were any.
bool DropPairs(const std::vector<Pass>& passes, const std::vector<size_t>& ends, qcClipMesh* mesh)
{
    std::vector<bool> isDropped;
    auto isFree = [&](const Pass& pass) { return isDropped.empty() || !isDropped[pass.triangle]; };
    auto thirdOf = [&](const Pass& pass, uint32_t low)
    {
        const std::array<uint32_t, 3>& v = mesh->triangles[pass.triangle].corner;
        return v[0] + v[1] + v[2] - low - pass.high;
    };
    size_t first = 0;
    for (uint32_t low = 0; low < ends.size(); low++)
        for (; first < ends[low]; first++)
            for (size_t i = first + 1; i < ends[low] && passes[i].high == passes[first].high; i++)
            {
                const Pass &a = passes[first], &b = passes[i];
                if (a.isDownward == b.isDownward || thirdOf(a, low) != thirdOf(b, low) || !isFree(a) || !isFree(b))
                    continue;
                isDropped.resize(mesh->triangles.size());
                isDropped[a.triangle] = isDropped[b.triangle] = true;
            }
    size_t kept = 0;
    for (size_t i = 0; i < isDropped.size(); i++)
    {
        mesh->triangles[kept] = mesh->triangles[i];
        kept += !isDropped[i];
    }
    if (!isDropped.empty())
        mesh->triangles.resize(kept);
    return !isDropped.empty();
}

//  ---- the cut ---------------------------------------------------------------------------------------

/// Fills the sides of points. Whether any is outside.
bool FindSides(const qcClipSolid& solid, const qcClipPlane& plane, std::vector<double>* sides)
{
    sides->resize(solid.points.size());
    bool any = false;
    for (size_t i = 0; i < solid.points.size(); i++)
    {
        double side = qcDotOf(plane.normal, solid.points[i]) - plane.distance;
        (*sides)[i] = side;
        any |= side > 0;
    }
    return any;
}

/// Puts the points that are not outside into the scratch, with their places there.
void KeepInside(const qcClipSolid& solid, qcClipScratch* scratch)
{
    size_t count = solid.points.size();
    scratch->places.resize(count);
    scratch->points.resize(count);
    uint32_t kept = 0;
    for (size_t i = 0; i < count; i++)
    {
        bool isInside = !(scratch->sides[i] > 0);
        scratch->places[i] = isInside ? kept : s_none;
        scratch->points[kept] = solid.points[i];
        kept += isInside;
    }
    scratch->points.resize(kept);
}

/// Where an edge meets the plane. Always from the nearer point on: the plane's mirror image finds the same.
qcClipPoint Crossing(const qcClipSolid& solid, const std::vector<double>& sides, uint32_t a, uint32_t b)
{
    double nearer = std::abs(sides[a]), further = std::abs(sides[b]);
    if (nearer > further || (nearer == further && a > b))
        std::swap(a, b);
    const qcClipPoint &p = solid.points[a], &q = solid.points[b];
    double t = sides[a] / (sides[a] - sides[b]);
    return {p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2])};
}

/// What the plane does to each face that it cuts.
class Seams
{
  public:
    explicit Seams(qcClipScratch* scratch) : m_seams(scratch->seams), m_places(scratch->seamOf), m_more(scratch->ends)
    {
        m_seams.clear();
        m_more.clear();
    }

    /// A face leaves the inside at a point.
    void Leave(uint32_t face, uint32_t point)
    {
        Add(face, point, &qcClipSeam::leave, true);
    }

    /// It comes back.
    void Enter(uint32_t face, uint32_t point)
    {
        Add(face, point, &qcClipSeam::enter, false);
    }

    /// Adds the edges that close all faces, with a new one beyond them.
    void Close(uint32_t newFace, const std::vector<qcClipPoint>& points, std::vector<qcClipEdge>* edges)
    {
        std::stable_sort(m_more.begin(), m_more.end(),
                         [](const qcClipEnd& a, const qcClipEnd& b) { return a.face < b.face; });
        for (const qcClipSeam& seam : m_seams)
        {
            auto isBefore = [](const qcClipEnd& end, uint32_t face) { return end.face < face; };
            auto first =
                m_more.empty() ? m_more.end() : std::lower_bound(m_more.begin(), m_more.end(), seam.face, isBefore);
            if (first == m_more.end() || first->face != seam.face)
                edges->push_back({seam.leave, seam.enter, seam.face, newFace});
            else
                CloseAlongLine(seam, size_t(first - m_more.begin()), newFace, points, edges);
        }
    }

  private:
    void Add(uint32_t face, uint32_t point, uint32_t qcClipSeam::*end, bool leaves)
    {
        if (face >= m_places.size())
            m_places.resize(face + 1);
        uint32_t& place = m_places[face];
        // What is in it may be left from other cuts.
        if (place >= m_seams.size() || m_seams[place].face != face)
        {
            place = uint32_t(m_seams.size());
            m_seams.push_back({face, s_none, s_none});
        }
        uint32_t& known = m_seams[place].*end;
        if (known == s_none)
            known = point;
        else
            m_more.push_back({face, point, leaves});
    }

    /// A face that comes back more than once.
    void CloseAlongLine(const qcClipSeam& seam, size_t first, uint32_t newFace, const std::vector<qcClipPoint>& points,
                        std::vector<qcClipEdge>* edges)
    {
        std::vector<uint32_t> leaves = {seam.leave}, enters = {seam.enter};
        for (size_t i = first; i < m_more.size() && m_more[i].face == seam.face; i++)
            (m_more[i].leaves ? leaves : enters).push_back(m_more[i].point);
        size_t axis = 0;
        double most = -1;
        for (size_t i = 0; i < 3; i++)
        {
            auto isLower = [&](uint32_t a, uint32_t b) { return points[a][i] < points[b][i]; };
            auto ends = std::minmax_element(leaves.begin(), leaves.end(), isLower);
            double length = points[*ends.second][i] - points[*ends.first][i];
            if (length > most)
            {
                most = length;
                axis = i;
            }
        }
        auto isLower = [&](uint32_t a, uint32_t b)
        { return std::make_pair(points[a][axis], a) < std::make_pair(points[b][axis], b); };
        std::sort(leaves.begin(), leaves.end(), isLower);
        std::sort(enters.begin(), enters.end(), isLower);
        for (size_t i = 0; i < leaves.size(); i++)
            edges->push_back({leaves[i], enters[i], seam.face, newFace});
    }

    std::vector<qcClipSeam>& m_seams;
    std::vector<uint32_t>& m_places; ///< by face, of its seam
    std::vector<qcClipEnd>& m_more;  ///< of faces that leave or come back more than once
};

//  ---- triangles -------------------------------------------------------------------------------------

/// Puts all edges into the scratch as each of their faces passes them, by face; the ends of those of each as well.
void SortByFace(const std::vector<qcClipEdge>& edges, qcClipScratch* scratch)
{
    std::vector<qcClipFaceEdges>& faces = scratch->faces;
    std::vector<uint32_t>& places = scratch->seamOf;
    faces.clear();
    auto count = [&](uint32_t face)
    {
        if (face >= places.size())
            places.resize(face + 1);
        uint32_t& place = places[face];
        if (place >= faces.size() || faces[place].face != face)
        {
            place = uint32_t(faces.size());
            faces.push_back({face, 0});
        }
        faces[place].end++;
    };
    for (const qcClipEdge& edge : edges)
    {
        count(edge.left);
        count(edge.right);
    }
    std::sort(faces.begin(), faces.end(),
              [](const qcClipFaceEdges& a, const qcClipFaceEdges& b) { return a.face < b.face; });
    size_t begin = 0;
    for (size_t i = 0; i < faces.size(); i++)
    {
        places[faces[i].face] = uint32_t(i);
        size_t length = faces[i].end;
        faces[i].end = begin;
        begin += length;
    }
    scratch->arrows.resize(begin);
    for (const qcClipEdge& edge : edges)
    {
        scratch->arrows[faces[places[edge.left]].end++] = {edge.from, edge.to};
        scratch->arrows[faces[places[edge.right]].end++] = {edge.to, edge.from};
    }
}
} // namespace

size_t qcClipSolid_Make(qcClipMesh* mesh, qcClipSolid* solid)
{
    std::vector<size_t> ends;
    std::vector<Pass> passes = SortPasses(*mesh, &ends);
    if (DropPairs(passes, ends, mesh))
        passes = SortPasses(*mesh, &ends);
    solid->points = mesh->points;
    solid->edges.clear();
    size_t open = mesh->triangles.size();
    for (size_t low = 0, first = 0; low < ends.size(); low++)
        while (first < ends[low])
        {
            uint32_t high = passes[first].high;
            size_t middle = first, last = first;
            for (; last < ends[low] && passes[last].high == high; last++)
                middle += !passes[last].isDownward;
            if (middle - first != last - middle)
                for (size_t i = first; i < last; i++)
                    open = std::min(open, size_t(passes[i].triangle));
            for (size_t i = 0; i < std::min(middle - first, last - middle); i++)
                solid->edges.push_back({uint32_t(low), high, mesh->triangles[passes[first + i].triangle].face,
                                        mesh->triangles[passes[middle + i].triangle].face});
            first = last;
        }
    return open;
}

void qcClipSolid_Cut(qcClipSolid* solid, const qcClipPlane& plane, qcClipScratch* scratch)
{
    if (!FindSides(*solid, plane, &scratch->sides))
        return;
    KeepInside(*solid, scratch);
    const std::vector<uint32_t>& places = scratch->places;
    std::vector<qcClipPoint>& points = scratch->points;
    Seams seams(scratch);
    size_t kept = 0;
    for (qcClipEdge edge : solid->edges)
    {
        uint32_t from = places[edge.from], to = places[edge.to];
        if (from == s_none && to == s_none)
            continue;
        if (from == s_none || to == s_none)
        {
            uint32_t made = uint32_t(points.size());
            points.push_back(Crossing(*solid, scratch->sides, edge.from, edge.to));
            seams.Leave(to == s_none ? edge.left : edge.right, made);
            seams.Enter(to == s_none ? edge.right : edge.left, made);
            (to == s_none ? to : from) = made;
        }
        solid->edges[kept++] = {from, to, edge.left, edge.right};
    }
    solid->edges.resize(kept);
    seams.Close(plane.face, points, &solid->edges);
    solid->points.swap(points);
}

void qcClipSolid_Triangulate(qcClipSolid* solid, qcClipMesh* mesh, qcClipScratch* scratch)
{
    std::vector<uint32_t>& places = scratch->places;
    qcWeldPoints(&solid->points, &places, scratch);
    scratch->edgesOf.assign(solid->points.size(), 0);
    size_t kept = 0;
    for (const qcClipEdge& edge : solid->edges)
    {
        uint32_t from = places[edge.from], to = places[edge.to];
        solid->edges[kept] = {from, to, edge.left, edge.right};
        kept += from != to;
        scratch->edgesOf[from] += from != to;
        scratch->edgesOf[to] += from != to;
    }
    solid->edges.resize(kept);
    SortByFace(solid->edges, scratch);
    mesh->points = solid->points;
    mesh->triangles.clear();
    size_t begin = 0;
    for (const qcClipFaceEdges& face : scratch->faces)
    {
        qcClipFace_Add(mesh, face.face, scratch->arrows.data() + begin, face.end - begin, scratch);
        begin = face.end;
    }
}
