// Clipping on the edges of faces. The edges of a face form closed chains, so a face that leaves the inside of the plane
// enters it again as often. An edge from each such point to another closes the face, and these edges together bound the
// cut face: the solid stays closed under any rounding of points. Any choice of joined points covers the same part of
// the line in which plane and face intersect. Joined in their order along the line, no two edges overlap.
#include "fracture/plane_clip.h"

#include "fracture/triangulate_face.h"

#include <algorithm>
#include <cmath>

namespace
{
constexpr uint32_t s_none = UINT32_MAX;
// In squared units of about the mesh's size: a face with less lies in a plane that crosses it, but for rounding.
constexpr double s_minFaceArea = 1e-13;

//  ---- the cut ---------------------------------------------------------------------------------------

// In units: points that are no further from a plane lie in it. The faces of a turned mesh are off their own planes by
// the rounding of their corners; what would be cut off is far below the tolerance of the sum of volumes.
constexpr double s_planeRounding = 2e-15;

// Min height of a triangle whose corners tell its plane, in roundings of them.
constexpr double s_minHeight = 100;

/// True if a triangle of the mesh lies in the plane, but for the rounding of its corners.
bool LiesIn(const qcClipPlane& plane, uint32_t face)
{
    const std::array<qcClipPoint, 3>& corners = plane.rounded->corners[face];
    double longest2 = 0;
    for (size_t c = 0; c < 3; c++)
    {
        if (std::abs(qcDotOf(plane.normal, corners[c]) - plane.distance) >= plane.rounded->rounding)
            return false;
        const qcClipPoint side = qcMinus(corners[(c + 1) % 3], corners[c]);
        longest2 = std::max(longest2, qcDotOf(side, side));
    }
    const qcClipPoint cross = qcCrossOf(qcMinus(corners[1], corners[0]), qcMinus(corners[2], corners[0]));
    return std::abs(qcDotOf(plane.normal, cross)) > s_minHeight * plane.rounded->rounding * std::sqrt(longest2);
}

/// Puts the points of the mesh's triangles that lie in the plane at distance 0. Whole triangles are tested: the cells
/// on both sides of the plane agree on them, whatever is left of these. The points stay where they are. True if there
/// are such triangles.
bool PutRoundedFacesInPlane(const qcClipSolid& solid, const qcClipPlane& plane, std::vector<double>* sides)
{
    const double near = plane.rounded->rounding;
    std::vector<uint32_t> faces;
    for (const qcClipEdge& edge : solid.edges)
        if (std::abs((*sides)[edge.from]) < near && std::abs((*sides)[edge.to]) < near)
            for (uint32_t face : {edge.left, edge.right})
                if (face < plane.rounded->corners.size())
                    faces.push_back(face);
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    faces.erase(std::remove_if(faces.begin(), faces.end(), [&](uint32_t face) { return !LiesIn(plane, face); }),
                faces.end());
    auto isInPlane = [&](uint32_t face) { return std::binary_search(faces.begin(), faces.end(), face); };
    for (const qcClipEdge& edge : solid.edges)
        if (!faces.empty() && (isInPlane(edge.left) || isInPlane(edge.right)))
            (*sides)[edge.from] = (*sides)[edge.to] = 0;
    return !faces.empty();
}

/// Points of a solid by their side of a plane.
struct SideCounts
{
    uint32_t kept = 0;  ///< not outside
    size_t inPlane = 0; ///< in the plane
    size_t near = 0;    ///< these, and others that may be of rounded faces in the plane
};

/// Fills the new indices of the points that are not outside. `sideOf`: the signed distance of a point from the plane.
template <typename Function> SideCounts IndexPoints(size_t count, double near, qcClipScratch* scratch, Function sideOf)
{
    scratch->sides.resize(count);
    scratch->newIndices.resize(count);
    double* sides = scratch->sides.data();
    uint32_t* newIndices = scratch->newIndices.data();
    SideCounts counts;
    for (size_t i = 0; i < count; i++)
    {
        sides[i] = sideOf(i);
        if (std::abs(sides[i]) < s_planeRounding)
            sides[i] = 0;
        uint32_t isOutside = sides[i] > 0;
        newIndices[i] = counts.kept | (0 - isOutside); // s_none outside
        counts.kept += 1 - isOutside;
        counts.inPlane += sides[i] == 0;
        counts.near += std::abs(sides[i]) < near;
    }
    return counts;
}

/// Fills the signed distances of the points from the plane and the new indices of those that are not outside.
/// `isRounded`: faces lie in the plane but for rounding.
SideCounts FindSides(const qcClipSolid& solid, const qcClipPlane& plane, qcClipScratch* scratch, bool* isRounded)
{
    const size_t count = solid.points.size();
    const qcClipPoint* points = solid.points.data();
    const double near = plane.rounded != nullptr ? plane.rounded->rounding : 0;
    const SideCounts counts =
        IndexPoints(count, near, scratch, [&](size_t i) { return qcDotOf(plane.normal, points[i]) - plane.distance; });
    *isRounded = counts.near >= 3 && PutRoundedFacesInPlane(solid, plane, &scratch->sides);
    return *isRounded ? IndexPoints(count, near, scratch, [&](size_t i) { return scratch->sides[i]; }) : counts;
}

/// The faces that lie in the plane, sorted: those with what is inside of it behind them, and those with what is
/// outside.
struct PlaneFaces
{
    std::vector<uint32_t> inside, outside;

    bool IsInside(uint32_t face) const
    {
        return std::binary_search(inside.begin(), inside.end(), face);
    }

    bool IsOutside(uint32_t face) const
    {
        return std::binary_search(outside.begin(), outside.end(), face);
    }
};

PlaneFaces FindPlaneFaces(const qcClipSolid& solid, const qcClipPlane& plane, const std::vector<double>& sides)
{
    struct FaceEdge
    {
        uint32_t face, from, to;
    };
    std::vector<FaceEdge> edges;
    for (const qcClipEdge& edge : solid.edges)
        if (sides[edge.from] == 0 && sides[edge.to] == 0)
        {
            edges.push_back({edge.left, edge.from, edge.to});
            edges.push_back({edge.right, edge.to, edge.from});
        }
    std::sort(edges.begin(), edges.end(), [](const FaceEdge& a, const FaceEdge& b) { return a.face < b.face; });
    // Twice a face's area, along the plane's normal. The edges of a face that the plane crosses lie on one line: no
    // area.
    PlaneFaces faces;
    for (size_t i = 0; i < edges.size();)
    {
        const uint32_t face = edges[i].face;
        const qcClipPoint about = solid.points[edges[i].from];
        double area = 0;
        for (; i < edges.size() && edges[i].face == face; i++)
            area += qcDotOf(plane.normal, qcCrossOf(qcMinus(solid.points[edges[i].from], about),
                                                    qcMinus(solid.points[edges[i].to], about)));
        if (std::abs(area) > s_minFaceArea)
            (area > 0 ? faces.inside : faces.outside).push_back(face);
    }
    return faces;
}

/// Copies the edges with an end that is not outside, in order, with the new indices of their ends; lists those with one
/// end outside. No branches: which edges are kept follows no pattern.
void KeepEdges(const qcClipSolid& from, qcClipScratch* scratch, std::vector<qcClipEdge>* to)
{
    size_t count = from.edges.size(), kept = 0, crossed = 0;
    to->resize(count);
    if (scratch->crossedEdges.size() < count)
        scratch->crossedEdges.resize(count);
    const uint32_t* newIndices = scratch->newIndices.data();
    const qcClipEdge* edges = from.edges.data();
    qcClipEdge* keptEdges = to->data();
    qcCrossedEdge* crossedEdges = scratch->crossedEdges.data();
    for (size_t i = 0; i < count; i++)
    {
        const qcClipEdge edge = edges[i];
        uint32_t start = newIndices[edge.from], end = newIndices[edge.to];
        keptEdges[kept] = edge;
        keptEdges[kept].from = start;
        keptEdges[kept].to = end;
        crossedEdges[crossed] = {edge.from, edge.to, kept};
        kept += (start & end) != s_none;
        crossed += (start == s_none) != (end == s_none);
    }
    to->resize(kept);
    scratch->crossedCount = crossed;
}

/// Copies the points that are not outside, `kept` of them, in order.
void KeepPoints(const std::vector<qcClipPoint>& from, const qcClipScratch& scratch, uint32_t kept,
                std::vector<qcClipPoint>* to)
{
    size_t count = from.size(), at = 0;
    to->resize(count);
    const qcClipPoint* points = from.data();
    qcClipPoint* keptPoints = to->data();
    for (size_t i = 0; i < count; i++)
    {
        keptPoints[at] = points[i];
        at += scratch.newIndices[i] != s_none;
    }
    to->resize(kept);
}

/// Intersection of an edge with the plane, computed from its nearer point: a mirrored plane gives the same point.
qcClipPoint Crossing(const qcClipSolid& solid, const std::vector<double>& sides, uint32_t a, uint32_t b)
{
    double nearer = std::abs(sides[a]), further = std::abs(sides[b]);
    if (nearer > further || (nearer == further && a > b))
        std::swap(a, b);
    const qcClipPoint &p = solid.points[a], &q = solid.points[b];
    double t = sides[a] / (sides[a] - sides[b]);
    return {p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2])};
}

/// The edges that close the faces which the plane cuts.
class CutEdges
{
  public:
    explicit CutEdges(qcClipScratch* scratch)
        : m_cutEdges(scratch->cutEdges), m_cutEdgeOf(scratch->cutEdgeOf), m_extraPoints(scratch->extraPoints)
    {
        m_cutEdges.clear();
        m_extraPoints.clear();
    }

    /// A face leaves the inside at a point.
    void Leave(uint32_t face, uint32_t point)
    {
        Add(face, point, &qcCutEdge::leave, true);
    }

    /// A face enters the inside at a point.
    void Enter(uint32_t face, uint32_t point)
    {
        Add(face, point, &qcCutEdge::enter, false);
    }

    /// Appends the edges that close all faces; the cut face is on their other side.
    void Close(uint32_t cutFace, const std::vector<qcClipPoint>& points, std::vector<qcClipEdge>* edges)
    {
        std::stable_sort(m_extraPoints.begin(), m_extraPoints.end(),
                         [](const qcCutPoint& a, const qcCutPoint& b) { return a.face < b.face; });
        for (const qcCutEdge& cutEdge : m_cutEdges)
        {
            auto isBefore = [](const qcCutPoint& end, uint32_t face) { return end.face < face; };
            auto first = m_extraPoints.empty()
                             ? m_extraPoints.end()
                             : std::lower_bound(m_extraPoints.begin(), m_extraPoints.end(), cutEdge.face, isBefore);
            if (first == m_extraPoints.end() || first->face != cutEdge.face)
                edges->push_back({cutEdge.leave, cutEdge.enter, cutEdge.face, cutFace});
            else
                CloseAlongLine(cutEdge, size_t(first - m_extraPoints.begin()), cutFace, points, edges);
        }
    }

  private:
    void Add(uint32_t face, uint32_t point, uint32_t qcCutEdge::*end, bool leaves)
    {
        if (face >= m_cutEdgeOf.size())
            m_cutEdgeOf.resize(face + 1);
        uint32_t& index = m_cutEdgeOf[face];
        // The entry may be of an earlier cut.
        if (index >= m_cutEdges.size() || m_cutEdges[index].face != face)
        {
            index = uint32_t(m_cutEdges.size());
            m_cutEdges.push_back({face, s_none, s_none});
        }
        uint32_t& existing = m_cutEdges[index].*end;
        if (existing == s_none)
            existing = point;
        else
            m_extraPoints.push_back({face, point, leaves});
    }

    /// Closes a face that leaves the inside more than once: joins points in their order along the line of intersection.
    void CloseAlongLine(const qcCutEdge& cutEdge, size_t first, uint32_t cutFace,
                        const std::vector<qcClipPoint>& points, std::vector<qcClipEdge>* edges)
    {
        std::vector<uint32_t> leaves = {cutEdge.leave}, enters = {cutEdge.enter};
        for (size_t i = first; i < m_extraPoints.size() && m_extraPoints[i].face == cutEdge.face; i++)
            (m_extraPoints[i].leaves ? leaves : enters).push_back(m_extraPoints[i].point);
        size_t axis = qcLongestAxis(leaves, [&](uint32_t point, size_t i) { return points[point][i]; });
        auto isLower = [&](uint32_t a, uint32_t b)
        { return std::make_pair(points[a][axis], a) < std::make_pair(points[b][axis], b); };
        std::sort(leaves.begin(), leaves.end(), isLower);
        std::sort(enters.begin(), enters.end(), isLower);
        for (size_t i = 0; i < leaves.size(); i++)
            edges->push_back({leaves[i], enters[i], cutEdge.face, cutFace});
    }

    std::vector<qcCutEdge>& m_cutEdges;
    std::vector<uint32_t>& m_cutEdgeOf;     ///< by face
    std::vector<qcCutPoint>& m_extraPoints; ///< of faces that leave the inside more than once
};

//  ---- faces in the plane ----------------------------------------------------------------------------

/// An edge as it is inside of the plane. Faces in the plane that have the outside behind them are left out; where such
/// a face borders on one that has the inside behind it, the cut face will take its place: s_none. False: nothing is
/// left of the edge.
bool LeaveOutside(const PlaneFaces& faces, double start, double end, qcClipEdge* edge)
{
    if (start != 0 || end != 0)
        return start < 0 || end < 0;
    const bool isLeftOutside = faces.IsOutside(edge->left), isRightOutside = faces.IsOutside(edge->right);
    const uint32_t other = isLeftOutside ? edge->right : edge->left;
    if (isLeftOutside || isRightOutside)
        (isLeftOutside ? edge->left : edge->right) = s_none;
    return (!isLeftOutside && !isRightOutside) || faces.IsInside(other);
}

/// Lists the points in the plane where faces leave the inside or enter it: more half-edges of the face lead to them
/// than from them, or fewer. `ends`: by half-edge with an end in the plane; `leaves`: it leads to that.
void FindCutsInPlane(std::vector<qcCutPoint>* ends, std::vector<qcCutPoint>* cuts)
{
    auto key = [](const qcCutPoint& end) { return std::make_pair(end.face, end.point); };
    std::sort(ends->begin(), ends->end(), [&](const qcCutPoint& a, const qcCutPoint& b) { return key(a) < key(b); });
    for (size_t i = 0; i < ends->size();)
    {
        const qcCutPoint first = (*ends)[i];
        int leaving = 0;
        for (; i < ends->size() && key((*ends)[i]) == key(first); i++)
            leaving += (*ends)[i].leaves ? 1 : -1;
        if (first.face != s_none)
            cuts->insert(cuts->end(), size_t(std::abs(leaving)), {first.face, first.point, leaving > 0});
    }
}

/// Does what KeepEdges does, without the faces in the plane that have the outside behind them. Points in the plane are
/// kept where edges that are left have them. Returns how many points are kept.
uint32_t KeepEdgesInside(const qcClipSolid& from, const PlaneFaces& faces, uint32_t cutFace, qcClipScratch* scratch,
                         std::vector<qcClipEdge>* to)
{
    const std::vector<double>& sides = scratch->sides;
    std::vector<qcClipEdge> kept;
    std::vector<bool> isKept(sides.size());
    for (qcClipEdge edge : from.edges)
        if (LeaveOutside(faces, sides[edge.from], sides[edge.to], &edge))
        {
            kept.push_back(edge);
            isKept[edge.from] = isKept[edge.to] = true;
        }
    uint32_t count = 0;
    for (size_t i = 0; i < sides.size(); i++)
        scratch->newIndices[i] = sides[i] < 0 || (sides[i] == 0 && isKept[i]) ? count++ : s_none;
    std::vector<qcCutPoint> ends;
    scratch->crossedEdges.clear();
    for (size_t i = 0; i < kept.size(); i++)
    {
        qcClipEdge& edge = kept[i];
        const uint32_t start = scratch->newIndices[edge.from], end = scratch->newIndices[edge.to];
        if (start == s_none || end == s_none)
            scratch->crossedEdges.push_back({edge.from, edge.to, i});
        for (bool isEnd : {false, true})
            if (sides[isEnd ? edge.to : edge.from] == 0)
            {
                ends.push_back({edge.left, isEnd ? end : start, isEnd});
                ends.push_back({edge.right, isEnd ? end : start, !isEnd});
            }
        // An earlier cut may have a face of this number.
        edge = {start, end, edge.left != s_none ? edge.left : cutFace, edge.right != s_none ? edge.right : cutFace};
    }
    scratch->crossedCount = scratch->crossedEdges.size();
    FindCutsInPlane(&ends, &scratch->cutsInPlane);
    to->swap(kept);
    return count;
}

//  ---- triangles -------------------------------------------------------------------------------------

/// Fills the half-edges of the scratch, sorted by face, and the ends of those of each face.
void SortByFace(const std::vector<qcClipEdge>& edges, qcClipScratch* scratch)
{
    std::vector<qcFaceEdges>& faces = scratch->faces;
    std::vector<uint32_t>& faceIndex = scratch->faceIndex;
    faces.clear();
    auto count = [&](uint32_t face)
    {
        if (face >= faceIndex.size())
            faceIndex.resize(face + 1);
        uint32_t& index = faceIndex[face];
        if (index >= faces.size() || faces[index].face != face)
        {
            index = uint32_t(faces.size());
            faces.push_back({face, 0});
        }
        faces[index].end++;
    };
    for (const qcClipEdge& edge : edges)
    {
        count(edge.left);
        count(edge.right);
    }
    std::sort(faces.begin(), faces.end(), [](const qcFaceEdges& a, const qcFaceEdges& b) { return a.face < b.face; });
    size_t begin = 0;
    for (size_t i = 0; i < faces.size(); i++)
    {
        faceIndex[faces[i].face] = uint32_t(i);
        size_t length = faces[i].end;
        faces[i].end = begin;
        begin += length;
    }
    scratch->halfEdges.resize(begin);
    for (const qcClipEdge& edge : edges)
    {
        scratch->halfEdges[faces[faceIndex[edge.left]].end++] = {edge.from, edge.to};
        scratch->halfEdges[faces[faceIndex[edge.right]].end++] = {edge.to, edge.from};
    }
}
} // namespace

void qcClipSolid_Clip(const qcClipSolid& from, const qcClipPlane& plane, qcClipScratch* scratch, qcClipSolid* to)
{
    bool isRounded;
    const SideCounts counts = FindSides(from, plane, scratch, &isRounded);
    uint32_t kept = counts.kept;
    if (kept == from.points.size())
    {
        if (to != &from)
            *to = from;
        return;
    }
    to->mayTouchItself = from.mayTouchItself || counts.inPlane > 0;
    to->hasRoundedCuts = from.hasRoundedCuts || isRounded;
    const PlaneFaces faces = counts.inPlane >= 3 ? FindPlaneFaces(from, plane, scratch->sides) : PlaneFaces();
    // With all points of the plane, a face that has the outside behind it would stay as a sheet without thickness,
    // which joins what the plane parts.
    scratch->cutsInPlane.clear();
    if (faces.outside.empty())
        KeepEdges(from, scratch, &to->edges);
    else
        kept = KeepEdgesInside(from, faces, plane.face, scratch, &to->edges);
    CutEdges cutEdges(scratch);
    for (const qcCutPoint& cut : scratch->cutsInPlane)
        if (cut.leaves)
            cutEdges.Leave(cut.face, cut.point);
        else
            cutEdges.Enter(cut.face, cut.point);
    std::vector<qcClipPoint>& made = scratch->points;
    made.clear();
    for (size_t i = 0; i < scratch->crossedCount; i++)
    {
        const qcCrossedEdge& crossed = scratch->crossedEdges[i];
        qcClipEdge& edge = to->edges[crossed.kept];
        uint32_t point = kept + uint32_t(made.size());
        made.push_back(Crossing(from, scratch->sides, crossed.from, crossed.to));
        bool leaves = edge.to == s_none;
        cutEdges.Leave(leaves ? edge.left : edge.right, point);
        cutEdges.Enter(leaves ? edge.right : edge.left, point);
        (leaves ? edge.to : edge.from) = point;
    }
    KeepPoints(from.points, *scratch, kept, &to->points);
    to->points.insert(to->points.end(), made.begin(), made.end());
    cutEdges.Close(plane.face, to->points, &to->edges);
}

void qcClipSolid_Triangulate(qcClipSolid* solid, qcFacetedMesh* mesh, qcClipScratch* scratch)
{
    std::vector<uint32_t>& newIndices = scratch->newIndices;
    const size_t count = solid->points.size();
    qcWeldPoints(&solid->points, &newIndices, scratch);
    solid->mayTouchItself = solid->mayTouchItself || solid->points.size() < count;
    scratch->edgeCount.assign(solid->points.size(), 0);
    size_t kept = 0;
    for (const qcClipEdge& edge : solid->edges)
    {
        uint32_t from = newIndices[edge.from], to = newIndices[edge.to];
        solid->edges[kept] = {from, to, edge.left, edge.right};
        kept += from != to;
        scratch->edgeCount[from] += from != to;
        scratch->edgeCount[to] += from != to;
    }
    solid->edges.resize(kept);
    SortByFace(solid->edges, scratch);
    mesh->points = solid->points;
    mesh->triangles.clear();
    size_t begin = 0;
    for (const qcFaceEdges& face : scratch->faces)
    {
        qcClipFace_Add(mesh, face.face, scratch->halfEdges.data() + begin, face.end - begin, scratch);
        begin = face.end;
    }
}
