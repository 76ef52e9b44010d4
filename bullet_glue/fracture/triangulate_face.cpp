// Triangulates a face by ear clipping (Meisters: Polygons have ears, 1975), or by GLU's tesselator, which handles holes
// and islands, but takes thousands of instructions a point. GLU needs no GL context.
//
// Any triangulation of a loop covers each point of the plane as often as the loop winds around it, reversed triangles
// counted negative. So triangles that all face the right way do not overlap.
#include "fracture/triangulate_face.h"

#include "fracture/loop_groups.h"

#include <GL/glu.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <new>
#include <numeric>
#include <optional>

namespace
{
//  ---- one loop --------------------------------------------------------------------------------------

// Ear clipping is about quadratic. With limits of 50, 100 and 200 corners fracture takes equally long.
constexpr size_t s_maxCorners = 200;
constexpr uint32_t s_none = UINT32_MAX;
constexpr double s_flat = 1e-6;         ///< min height of a triangle by its length: pieces may be of single precision
constexpr double s_spikeHeight = 1e-12; ///< in units of about the mesh's size: what rounding makes of no height
constexpr double s_foldedArea = 1e-9;   ///< in squared units: what rounding makes of none
constexpr size_t s_maxStarts = 4;       ///< of searches for a triangulation without flat triangles

/// A single loop, projected along the normal.
class Outline
{
  public:
    Outline(const qcFacetedMesh& mesh, const qcClipPoint& normal, const qcClipLoops& loops, qcClipScratch* scratch)
        : m_corners(scratch->corners), m_inward(scratch->inward), m_remaining(scratch->remaining)
    {
        size_t axis = 0;
        for (size_t i = 1; i < 3; i++)
            if (std::fabs(normal[i]) > std::fabs(normal[axis]))
                axis = i;
        size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        if (normal[axis] < 0)
            std::swap(u, v);
        m_corners.clear();
        for (uint32_t point : loops.points)
        {
            uint32_t index = uint32_t(m_corners.size());
            m_corners.push_back({mesh.points[point][u], mesh.points[point][v], point, index, s_none, true});
        }
    }

    /// Adds triangles that all face the right way; none if no such triangulation is found. Corners are flat where a
    /// plane has cut coplanar triangles: the search prefers triangulations without flat triangles.
    bool Triangulate(uint32_t face, std::vector<qcClipTriangle>* triangles)
    {
        m_flat = s_flat;
        for (size_t start = 0; start < std::min(s_maxStarts, m_corners.size()); start++)
            if (CutEars(start, face, triangles))
                return true;
        m_flat = 0;
        return CutEars(0, face, triangles);
    }

  private:
    bool CutEars(size_t start, uint32_t face, std::vector<qcClipTriangle>* triangles)
    {
        size_t before = triangles->size();
        m_remaining.resize(m_corners.size());
        std::iota(m_remaining.begin(), m_remaining.end(), 0u);
        for (qcOutlineCorner& corner : m_corners)
        {
            corner.obstacle = s_none;
            corner.remains = true;
        }
        m_inward.clear();
        for (size_t i = 0; i < m_remaining.size(); i++)
            if (!IsTip(Remaining(i), Remaining(i + 1), Remaining(i + 2)))
                m_inward.push_back(Remaining(i + 1));
        // Ears around the outline in turn: ears at one corner would make a fan of slivers.
        for (size_t at = start, missed = 0; m_remaining.size() > 3 && missed < m_remaining.size(); at = Wrap(at + 1))
        {
            qcOutlineCorner& b = Remaining(at + 1);
            missed++;
            if (b.obstacle != s_none && m_corners[b.obstacle].remains)
                continue;
            qcOutlineCorner &a = Remaining(at), &c = Remaining(at + 2);
            b.obstacle = FindObstacle(a, b, c);
            if (b.obstacle != s_none)
                continue;
            b.remains = false;
            a.obstacle = c.obstacle = s_none;
            triangles->push_back({{a.point, b.point, c.point}, face});
            auto isTip = [&](const qcOutlineCorner& corner) { return corner.index == b.index; };
            m_inward.erase(std::remove_if(m_inward.begin(), m_inward.end(), isTip), m_inward.end());
            m_remaining.erase(m_remaining.begin() + std::ptrdiff_t(Wrap(at + 1)));
            missed = 0;
        }
        if (m_remaining.size() == 3 && IsTip(Remaining(0), Remaining(1), Remaining(2)))
            triangles->push_back({{Remaining(0).point, Remaining(1).point, Remaining(2).point}, face});
        else
            triangles->resize(before);
        return triangles->size() > before;
    }

    /// i modulo the number of remaining corners; i is less than three times that.
    size_t Wrap(size_t i) const
    {
        while (i >= m_remaining.size())
            i -= m_remaining.size();
        return i;
    }

    qcOutlineCorner& Remaining(size_t i)
    {
        return m_corners[m_remaining[Wrap(i)]];
    }

    /// Twice the signed area of a triangle, positive if it faces the right way.
    static double Turn(const qcOutlineCorner& a, const qcOutlineCorner& b, const qcOutlineCorner& c)
    {
        return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
    }

    /// True if a triangle faces the right way and is not flat.
    bool IsTip(const qcOutlineCorner& a, const qcOutlineCorner& b, const qcOutlineCorner& c) const
    {
        auto length2 = [](const qcOutlineCorner& p, const qcOutlineCorner& q)
        { return (q.u - p.u) * (q.u - p.u) + (q.v - p.v) * (q.v - p.v); };
        return Turn(a, b, c) > m_flat * (length2(a, b) + length2(b, c));
    }

    /// The index of a corner inside the triangle, or of the tip itself if it is reflex or flat; s_none: it is an ear.
    /// If any corner is inside, so is one that was reflex or flat from the start: the one furthest in.
    uint32_t FindObstacle(const qcOutlineCorner& a, const qcOutlineCorner& b, const qcOutlineCorner& c) const
    {
        if (!IsTip(a, b, c))
            return b.index;
        // Most corners are beyond the side that the ear does not share with the outline: it is tested first.
        for (const qcOutlineCorner& k : m_inward)
            if (Turn(c, a, k) >= 0 && Turn(a, b, k) >= 0 && Turn(b, c, k) >= 0 && k.point != a.point &&
                k.point != b.point && k.point != c.point)
                return k.index;
        return s_none;
    }

    std::vector<qcOutlineCorner>& m_corners;
    std::vector<qcOutlineCorner>& m_inward; ///< remaining corners that are reflex or flat
    std::vector<uint32_t>& m_remaining;
    double m_flat = 0;
};

//  ---- any loops -------------------------------------------------------------------------------------

/// Receives the tesselator's triangles.
struct Face
{
    qcFacetedMesh* mesh;
    std::vector<uint32_t> corners;
    bool failed = false;
    std::exception_ptr thrown; ///< by a callback: exceptions don't pass through GLU
};

/// Calls function(face) for a callback of the tesselator.
template <typename Function> void CallGuarded(void* context, Function function)
{
    Face* face = static_cast<Face*>(context);
    try
    {
        function(*face);
    }
    catch (...)
    {
        face->failed = true;
        face->thrown = std::current_exception();
    }
}

void* DataOf(uint32_t point)
{
    return reinterpret_cast<void*>(uintptr_t(point) + 1);
}

uint32_t PointOf(const void* data)
{
    return uint32_t(reinterpret_cast<uintptr_t>(data) - 1);
}

void APIENTRY OnVertex(void* data, void* context)
{
    CallGuarded(context, [data](Face& face) { face.corners.push_back(PointOf(data)); });
}

void APIENTRY OnEdge(GLboolean, void*)
{
    // Its presence makes the tesselator give single triangles.
}

void APIENTRY OnError(GLenum, void* face)
{
    static_cast<Face*>(face)->failed = true;
}

/// The point of the first segment that is nearest to the line through the second.
qcClipPoint Crossing(const qcClipPoint& a, const qcClipPoint& b, const qcClipPoint& c, const qcClipPoint& d)
{
    qcClipPoint u = qcMinus(b, a), v = qcMinus(d, c), w = qcMinus(a, c);
    double uu = qcDotOf(u, u), uv = qcDotOf(u, v), vv = qcDotOf(v, v), den = uu * vv - uv * uv;
    double t = den > 0 ? (uv * qcDotOf(v, w) - vv * qcDotOf(u, w)) / den : 0;
    t = std::min(std::max(t, 0.0), 1.0);
    return {a[0] + t * u[0], a[1] + t * u[1], a[2] + t * u[2]};
}

/// A point where edges of the loops cross or touch. The tesselator's own position is of single precision.
void APIENTRY OnCombine(GLdouble[3], void* data[4], GLfloat[4], void** out, void* context)
{
    std::vector<qcClipPoint>& points = static_cast<Face*>(context)->mesh->points;
    *out = data[0];
    if (data[2] == nullptr || data[3] == nullptr)
        return;
    qcClipPoint p = Crossing(points[PointOf(data[0])], points[PointOf(data[1])], points[PointOf(data[2])],
                             points[PointOf(data[3])]);
    for (int i = 0; i < 4; i++)
        if (points[PointOf(data[i])] == p)
        {
            *out = data[i];
            return;
        }
    auto add = [&](Face&)
    {
        points.push_back(p);
        *out = DataOf(uint32_t(points.size() - 1));
    };
    CallGuarded(context, add);
}

template <typename Function> void SetCallback(GLUtesselator* tesselator, GLenum which, Function function)
{
    gluTessCallback(tesselator, which, reinterpret_cast<void(APIENTRY*)()>(function));
}

/// Skips triangles with a point twice: loops may contain a point twice.
void AddTriangle(qcFacetedMesh* mesh, const std::array<uint32_t, 3>& v, uint32_t face)
{
    if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0])
        mesh->triangles.push_back({v, face});
}

void Tesselate(qcFacetedMesh* mesh, const qcClipPoint& normal, uint32_t number, const qcClipLoops& loops)
{
    if (loops.ends.empty())
        return;
    const std::unique_ptr<GLUtesselator, void(APIENTRY*)(GLUtesselator*)> owner(gluNewTess(), gluDeleteTess);
    GLUtesselator* tesselator = owner.get();
    if (tesselator == nullptr)
        throw std::bad_alloc();
    Face face{mesh, {}, false, nullptr};
    SetCallback(tesselator, GLU_TESS_VERTEX_DATA, OnVertex);
    SetCallback(tesselator, GLU_TESS_EDGE_FLAG_DATA, OnEdge);
    SetCallback(tesselator, GLU_TESS_ERROR_DATA, OnError);
    SetCallback(tesselator, GLU_TESS_COMBINE_DATA, OnCombine);
    gluTessProperty(tesselator, GLU_TESS_WINDING_RULE, GLU_TESS_WINDING_POSITIVE);
    gluTessNormal(tesselator, normal[0], normal[1], normal[2]);
    gluTessBeginPolygon(tesselator, &face);
    for (size_t loop = 0; loop < loops.ends.size(); loop++)
    {
        gluTessBeginContour(tesselator);
        for (size_t i = loops.Begin(loop); i < loops.ends[loop]; i++)
        {
            uint32_t point = loops.points[i];
            GLdouble position[3] = {mesh->points[point][0], mesh->points[point][1], mesh->points[point][2]};
            gluTessVertex(tesselator, position, DataOf(point));
        }
        gluTessEndContour(tesselator);
    }
    gluTessEndPolygon(tesselator);
    if (face.thrown != nullptr)
        std::rethrow_exception(face.thrown);
    for (size_t i = 0; i + 2 < face.corners.size() && !face.failed; i += 3)
        AddTriangle(mesh, {face.corners[i], face.corners[i + 1], face.corners[i + 2]}, number);
}

/// The square of the length of twice a triangle's vector area.
double SquaredArea(const qcFacetedMesh& mesh, uint32_t a, uint32_t b, uint32_t c)
{
    const qcClipPoint cross =
        qcCrossOf(qcMinus(mesh.points[b], mesh.points[a]), qcMinus(mesh.points[c], mesh.points[a]));
    return qcDotOf(cross, cross);
}

/// Fills a loop, whatever its shape, the corner with the smallest triangle first: the two sides of a loop without area
/// meet in triangles without area. A fan would have large ones back to back. O(points * points).
void FillLoop(qcFacetedMesh* mesh, std::vector<uint32_t> loop, uint32_t face)
{
    std::vector<double> areas(loop.size());
    auto at = [&](size_t i) { return loop[i % loop.size()]; };
    auto measure = [&](size_t i)
    { areas[i % loop.size()] = SquaredArea(*mesh, at(i + loop.size() - 1), at(i), at(i + 1)); };
    for (size_t i = 0; i < loop.size(); i++)
        measure(i);
    while (loop.size() >= 3)
    {
        const auto smallest = std::min_element(areas.begin(), areas.end());
        const size_t i = size_t(smallest - areas.begin());
        AddTriangle(mesh, {at(i + loop.size() - 1), at(i), at(i + 1)}, face);
        areas.erase(smallest);
        loop.erase(loop.begin() + std::ptrdiff_t(i));
        measure(i + loop.size() - 1);
        measure(i);
    }
}

/// Fills loops, each by itself.
void FillLoops(qcFacetedMesh* mesh, uint32_t face, const qcClipLoops& loops)
{
    for (size_t loop = 0; loop < loops.ends.size(); loop++)
        FillLoop(mesh,
                 {loops.points.begin() + std::ptrdiff_t(loops.Begin(loop)),
                  loops.points.begin() + std::ptrdiff_t(loops.ends[loop])},
                 face);
}

/// Closes the edges that the face's triangles, from `first` on, leave open. What does so may overlap: closedness and
/// the signed volume matter most. This happens to loops without area, or that cross.
void FillOpenLoops(qcFacetedMesh* mesh, size_t first, uint32_t face, const qcClipLoops& loops, qcClipScratch* scratch)
{
    scratch->edges.Clear(loops.points.size());
    for (size_t loop = 0; loop < loops.ends.size(); loop++)
        for (size_t begin = loops.Begin(loop), i = begin, end = loops.ends[loop]; i < end; i++)
            scratch->edges.Add(loops.points[i + 1 < end ? i + 1 : begin], loops.points[i]);
    for (size_t i = first; i < mesh->triangles.size(); i++)
        scratch->edges.Add(mesh->triangles[i].corner);
    scratch->edges.FindLoops(true, &scratch->openLoops);
    FillLoops(mesh, face, scratch->openLoops);
}

//  ---- loops of edges --------------------------------------------------------------------------------

/// The loop of a face whose half-edges form a single loop with each point once, as in nearly all faces. False for other
/// faces.
bool FindSimpleLoop(const qcHalfEdge* halfEdges, size_t count, size_t pointCount, qcClipScratch* scratch)
{
    qcClipLoops* loops = &scratch->loops;
    std::vector<uint32_t>& halfEdgeFrom = scratch->halfEdgeFrom;
    halfEdgeFrom.resize(std::max(halfEdgeFrom.size(), pointCount));
    for (size_t i = 0; i < count; i++)
        halfEdgeFrom[halfEdges[i].from] = uint32_t(i);
    loops->points.clear();
    loops->ends.clear();
    size_t at = 0;
    do
    {
        loops->points.push_back(halfEdges[at].from);
        at = halfEdgeFrom[halfEdges[at].to];
    } while (at != 0 && loops->points.size() < count);
    loops->ends.push_back(loops->points.size());
    return at == 0 && loops->points.size() == count;
}

/// Drops points at which only two edges meet: both edges are between the same two faces, so they are collinear. A loop
/// may lose all points.
void DropBends(const std::vector<uint32_t>& edgeCount, qcClipLoops* loops)
{
    size_t kept = 0, keptLoops = 0, i = 0;
    for (size_t end : loops->ends)
    {
        size_t first = kept;
        for (; i < end; i++)
            if (edgeCount[loops->points[i]] != 2)
                loops->points[kept++] = loops->points[i];
        if (kept - first < 3)
            kept = first;
        else
            loops->ends[keptLoops++] = kept;
    }
    loops->points.resize(kept);
    loops->ends.resize(keptLoops);
}

/// True if a loop turns back along itself at b.
bool IsSpike(const qcClipPoint& a, const qcClipPoint& b, const qcClipPoint& c)
{
    const qcClipPoint u = qcMinus(a, b), v = qcMinus(c, b), cross = qcCrossOf(u, v);
    const double length2 = std::max(qcDotOf(u, u), qcDotOf(v, v));
    return qcDotOf(u, v) > 0 && qcDotOf(cross, cross) <= s_spikeHeight * s_spikeHeight * length2;
}

/// Cuts off spikes, with a flat triangle each. The tesselator, which cannot tell their two sides from each other, may
/// leave out corners next to them. A loop may lose all points. False: there are none.
bool CutSpikes(qcFacetedMesh* mesh, uint32_t face, qcClipLoops* loops)
{
    const size_t before = loops->points.size();
    qcClipLoops kept;
    for (size_t loop = 0; loop < loops->ends.size(); loop++)
    {
        std::vector<uint32_t> points(loops->points.begin() + std::ptrdiff_t(loops->Begin(loop)),
                                     loops->points.begin() + std::ptrdiff_t(loops->ends[loop]));
        for (size_t i = 0, passed = 0; passed < points.size() && points.size() >= 3;)
        {
            const size_t count = points.size();
            const uint32_t a = points[(i + count - 1) % count], b = points[i % count], c = points[(i + 1) % count];
            if (!IsSpike(mesh->points[a], mesh->points[b], mesh->points[c]))
            {
                i++;
                passed++;
                continue;
            }
            AddTriangle(mesh, {a, b, c}, face);
            points.erase(points.begin() + std::ptrdiff_t(i % count));
            // The corner before it may be the next tip.
            i = (i + count - 1) % count;
            i = i < points.size() ? i : 0;
            passed = 0;
        }
        if (points.size() < 3)
            continue;
        kept.points.insert(kept.points.end(), points.begin(), points.end());
        kept.ends.push_back(kept.points.size());
    }
    *loops = std::move(kept);
    return loops->points.size() != before;
}

/// The part of the way from a to b at which p lies on it; none: it does not.
std::optional<double> PartOfWay(const qcClipPoint& a, const qcClipPoint& b, const qcClipPoint& p)
{
    const qcClipPoint way = qcMinus(b, a), to = qcMinus(p, a), cross = qcCrossOf(way, to);
    const double length2 = qcDotOf(way, way), along = qcDotOf(way, to);
    if (!(along > 0 && along < length2) || qcDotOf(cross, cross) > s_spikeHeight * s_spikeHeight * length2)
        return std::nullopt;
    return along / length2;
}

/// Has edges pass through the corners that lie on them, with a flat triangle each: the tesselator may leave out such a
/// corner. O(corners * corners).
void SplitAtCorners(qcFacetedMesh* mesh, uint32_t face, qcClipLoops* loops)
{
    qcClipLoops split;
    for (size_t loop = 0; loop < loops->ends.size(); loop++)
    {
        for (size_t begin = loops->Begin(loop), i = begin, end = loops->ends[loop]; i < end; i++)
        {
            const uint32_t a = loops->points[i], b = loops->points[i + 1 < end ? i + 1 : begin];
            std::vector<std::pair<double, uint32_t>> between;
            for (uint32_t p : loops->points)
                if (p != a && p != b)
                    if (auto part = PartOfWay(mesh->points[a], mesh->points[b], mesh->points[p]))
                        between.emplace_back(*part, p);
            std::sort(between.begin(), between.end());
            between.erase(std::unique(between.begin(), between.end()), between.end());
            split.points.push_back(a);
            uint32_t last = b;
            for (size_t k = between.size(); k-- > 0; last = between[k].second)
                AddTriangle(mesh, {a, last, between[k].second}, face);
            for (const auto& corner : between)
                split.points.push_back(corner.second);
        }
        split.ends.push_back(split.points.size());
    }
    *loops = std::move(split);
}

/// The normal of the loops, with twice their area as its length.
qcClipPoint NormalOf(const qcFacetedMesh& mesh, const qcClipLoops& loops)
{
    qcClipPoint normal = {0, 0, 0};
    for (size_t loop = 0; loop < loops.ends.size(); loop++)
        for (size_t first = loops.Begin(loop), i = first, end = loops.ends[loop]; i < end; i++)
        {
            const qcClipPoint &from = mesh.points[loops.points[first]], &a = mesh.points[loops.points[i]],
                              &b = mesh.points[loops.points[i + 1 < end ? i + 1 : first]];
            for (size_t k = 0; k < 3; k++)
            {
                size_t u = (k + 1) % 3, v = (k + 2) % 3;
                normal[k] += (a[u] - from[u]) * (b[v] - from[v]) - (a[v] - from[v]) * (b[u] - from[u]);
            }
        }
    return normal;
}

/// Triangulates loops of any kind. Some parts of the plane may be covered by triangles back to back.
void TriangulateAny(qcFacetedMesh* mesh, const qcClipPoint& normal, uint32_t face, const qcClipLoops& loops,
                    qcClipScratch* scratch)
{
    const size_t first = mesh->triangles.size();
    Tesselate(mesh, normal, face, loops);
    FillOpenLoops(mesh, first, face, loops, scratch);
}

/// By how much the triangles from `first` on have more area than their face, whose normal has twice its area as its
/// length.
double FoldedArea(const qcFacetedMesh& mesh, size_t first, const qcClipPoint& normal)
{
    double area = 0;
    for (size_t i = first; i < mesh.triangles.size(); i++)
    {
        const std::array<uint32_t, 3>& v = mesh.triangles[i].corner;
        area += std::sqrt(SquaredArea(mesh, v[0], v[1], v[2])) / 2;
    }
    return area - std::sqrt(qcDotOf(normal, normal)) / 2;
}

/// Replaces the triangles from `first` on by those that a function adds, if these are folded less.
template <typename Function>
void Unfold(qcFacetedMesh* mesh, size_t first, const qcClipPoint& normal, Function addOthers)
{
    const double folded = FoldedArea(*mesh, first, normal);
    if (folded < s_foldedArea)
        return;
    const std::vector<qcClipTriangle> triangles(mesh->triangles.begin() + std::ptrdiff_t(first), mesh->triangles.end());
    mesh->triangles.resize(first);
    addOthers();
    if (FoldedArea(*mesh, first, normal) < folded)
        return;
    mesh->triangles.resize(first);
    mesh->triangles.insert(mesh->triangles.end(), triangles.begin(), triangles.end());
}

/// Adds the triangles of loops, which may lose points.
void TriangulateLoops(qcFacetedMesh* mesh, const qcClipPoint& normal, uint32_t face, qcClipLoops* loops,
                      qcClipScratch* scratch)
{
    size_t first = mesh->triangles.size();
    auto hasOutline = [&]
    {
        first = mesh->triangles.size();
        return loops->ends.size() == 1 && loops->points.size() <= s_maxCorners &&
               Outline(*mesh, normal, *loops, scratch).Triangulate(face, &mesh->triangles);
    };
    const bool isOutline = hasOutline() || (CutSpikes(mesh, face, loops) && hasOutline());
    if (!isOutline)
        TriangulateAny(mesh, normal, face, *loops, scratch);
    if (loops->points.size() > s_maxCorners)
        return;
    // The normal of a loop without area is one of rounding, and large triangles back to back may face its way.
    Unfold(mesh, first, normal, [&] { FillLoops(mesh, face, *loops); });
    Unfold(mesh, first, normal,
           [&]
           {
               SplitAtCorners(mesh, face, loops);
               TriangulateAny(mesh, normal, face, *loops, scratch);
           });
}
} // namespace

void qcClipFace_Add(qcFacetedMesh* mesh, uint32_t face, const qcHalfEdge* halfEdges, size_t count,
                    qcClipScratch* scratch)
{
    qcClipLoops& loops = scratch->loops;
    if (!FindSimpleLoop(halfEdges, count, mesh->points.size(), scratch))
    {
        scratch->edges.Clear(count);
        for (size_t i = 0; i < count; i++)
            scratch->edges.Add(halfEdges[i].from, halfEdges[i].to);
        scratch->edges.FindLoops(false, &loops);
    }
    DropBends(scratch->edgeCount, &loops);
    if (loops.ends.empty())
        return;
    if (loops.points.size() == 3)
    {
        AddTriangle(mesh, {loops.points[0], loops.points[1], loops.points[2]}, face);
        return;
    }
    const qcClipPoint normal = NormalOf(*mesh, loops);
    if (loops.points.size() <= s_maxCorners || loops.ends.size() == 1)
    {
        TriangulateLoops(mesh, normal, face, &loops, scratch);
        return;
    }
    for (qcClipLoops& group : qcGroupLoops(mesh->points, loops))
        TriangulateLoops(mesh, normal, face, &group, scratch);
}
