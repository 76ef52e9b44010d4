// A face by cutting off ears (Meisters: Polygons have ears, 1975), or by GLU's tesselator (it needs no GL context),
// which takes holes and islands alike, but thousands of instructions a point.
//
// However a loop is triangulated, how often triangles cover a place (those that are turned counted off) is how often
// the loop goes round it. So where each triangle faces the right way they lie side by side.
#include "fracture/triangulate_face.h"

#include <GL/glu.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace
{
//  ---- one loop --------------------------------------------------------------------------------------

// Ears take about the square of the points: with 50, 100 or 200 of them at most, fracture takes as long.
constexpr size_t s_mostCorners = 200;
constexpr uint32_t s_none = UINT32_MAX;
constexpr double s_flat = 1e-6;    ///< height by length: pieces may be of single precision
constexpr size_t s_mostStarts = 4; ///< tried in a search for triangles that are not flat

/// The only loop, as the normal sees it.
class Outline
{
  public:
    Outline(const qcClipMesh& mesh, const qcClipPoint& normal, const qcClipLoops& loops, qcClipScratch* scratch)
        : m_corners(scratch->corners), m_inward(scratch->inward), m_left(scratch->left)
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
            uint32_t place = uint32_t(m_corners.size());
            m_corners.push_back({mesh.points[point][u], mesh.points[point][v], point, place, s_none, true});
        }
    }

    /// Adds triangles of corners that all face the right way; none if it finds no such. Where a plane has cut triangles
    /// that lie in one plane, corners are flat: first it looks for triangles none of which is.
    bool Triangulate(uint32_t face, std::vector<qcClipTriangle>* triangles)
    {
        m_flat = s_flat;
        for (size_t start = 0; start < std::min(s_mostStarts, m_corners.size()); start++)
            if (CutEars(start, face, triangles))
                return true;
        m_flat = 0;
        return CutEars(0, face, triangles);
    }

  private:
    bool CutEars(size_t start, uint32_t face, std::vector<qcClipTriangle>* triangles)
    {
        size_t before = triangles->size();
        m_left.resize(m_corners.size());
        std::iota(m_left.begin(), m_left.end(), 0u);
        for (qcClipCorner& corner : m_corners)
        {
            corner.obstacle = s_none;
            corner.isLeft = true;
        }
        m_inward.clear();
        for (size_t i = 0; i < m_left.size(); i++)
            if (!IsTip(Left(i), Left(i + 1), Left(i + 2)))
                m_inward.push_back(Left(i + 1));
        // Round and round: from one corner they would be a fan of slivers.
        for (size_t at = start, missed = 0; m_left.size() > 3 && missed < m_left.size(); at = Wrap(at + 1))
        {
            qcClipCorner& b = Left(at + 1);
            missed++;
            if (b.obstacle != s_none && m_corners[b.obstacle].isLeft)
                continue;
            qcClipCorner &a = Left(at), &c = Left(at + 2);
            b.obstacle = FindObstacle(a, b, c);
            if (b.obstacle != s_none)
                continue;
            b.isLeft = false;
            a.obstacle = c.obstacle = s_none;
            triangles->push_back({{a.point, b.point, c.point}, face});
            auto isTip = [&](const qcClipCorner& corner) { return corner.place == b.place; };
            m_inward.erase(std::remove_if(m_inward.begin(), m_inward.end(), isTip), m_inward.end());
            m_left.erase(m_left.begin() + std::ptrdiff_t(Wrap(at + 1)));
            missed = 0;
        }
        if (m_left.size() == 3 && IsTip(Left(0), Left(1), Left(2)))
            triangles->push_back({{Left(0).point, Left(1).point, Left(2).point}, face});
        else
            triangles->resize(before);
        return triangles->size() > before;
    }

    /// As the remainder, of less than three times as many as are left.
    size_t Wrap(size_t i) const
    {
        while (i >= m_left.size())
            i -= m_left.size();
        return i;
    }

    qcClipCorner& Left(size_t i)
    {
        return m_corners[m_left[Wrap(i)]];
    }

    /// Twice the area of a triangle, positive if it faces the right way.
    static double Turn(const qcClipCorner& a, const qcClipCorner& b, const qcClipCorner& c)
    {
        return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
    }

    /// Whether a triangle faces the right way, and is not flat.
    bool IsTip(const qcClipCorner& a, const qcClipCorner& b, const qcClipCorner& c) const
    {
        auto length2 = [](const qcClipCorner& p, const qcClipCorner& q)
        { return (q.u - p.u) * (q.u - p.u) + (q.v - p.v) * (q.v - p.v); };
        return Turn(a, b, c) > m_flat * (length2(a, b) + length2(b, c));
    }

    /// A corner that is in the triangle, the tip itself if it faces the wrong way, or none. Of what is in it the corner
    /// furthest in turns inward, and did so from the start.
    uint32_t FindObstacle(const qcClipCorner& a, const qcClipCorner& b, const qcClipCorner& c) const
    {
        if (!IsTip(a, b, c))
            return b.place;
        // Most are beyond the side that the ear does not share with the outline.
        for (const qcClipCorner& k : m_inward)
            if (Turn(c, a, k) >= 0 && Turn(a, b, k) >= 0 && Turn(b, c, k) >= 0 && k.point != a.point &&
                k.point != b.point && k.point != c.point)
                return k.place;
        return s_none;
    }

    std::vector<qcClipCorner>& m_corners;
    std::vector<qcClipCorner>& m_inward; ///< corners left that don't turn to the left
    std::vector<uint32_t>& m_left;
    double m_flat = 0;
};

//  ---- any loops -------------------------------------------------------------------------------------

/// What the tesselator makes.
struct Face
{
    qcClipMesh* mesh;
    std::vector<uint32_t> corners;
    bool failed = false;
};

void* DataOf(uint32_t point)
{
    return reinterpret_cast<void*>(uintptr_t(point) + 1);
}

uint32_t PointOf(const void* data)
{
    return uint32_t(reinterpret_cast<uintptr_t>(data) - 1);
}

void APIENTRY OnVertex(void* data, void* face)
{
    static_cast<Face*>(face)->corners.push_back(PointOf(data));
}

void APIENTRY OnEdge(GLboolean, void*)
{
    // That it is there makes the tesselator give single triangles.
}

void APIENTRY OnError(GLenum, void* face)
{
    static_cast<Face*>(face)->failed = true;
}

qcClipPoint Minus(const qcClipPoint& a, const qcClipPoint& b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// The point of the first segment that is nearest to the line through the second.
qcClipPoint Crossing(const qcClipPoint& a, const qcClipPoint& b, const qcClipPoint& c, const qcClipPoint& d)
{
    qcClipPoint u = Minus(b, a), v = Minus(d, c), w = Minus(a, c);
    double uu = qcDotOf(u, u), uv = qcDotOf(u, v), vv = qcDotOf(v, v), den = uu * vv - uv * uv;
    double t = den > 0 ? (uv * qcDotOf(v, w) - vv * qcDotOf(u, w)) / den : 0;
    t = std::min(std::max(t, 0.0), 1.0);
    return {a[0] + t * u[0], a[1] + t * u[1], a[2] + t * u[2]};
}

/// Where edges of the loops cross or touch. The position that the tesselator gives is of single precision.
void APIENTRY OnCombine(GLdouble[3], void* data[4], GLfloat[4], void** out, void* context)
{
    Face* face = static_cast<Face*>(context);
    std::vector<qcClipPoint>& points = face->mesh->points;
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
    points.push_back(p);
    *out = DataOf(uint32_t(points.size() - 1));
}

template <typename Function> void SetCallback(GLUtesselator* tesselator, GLenum which, Function function)
{
    gluTessCallback(tesselator, which, reinterpret_cast<void(APIENTRY*)()>(function));
}

/// Loops may pass a point twice.
void AddTriangle(qcClipMesh* mesh, const std::array<uint32_t, 3>& v, uint32_t face)
{
    if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0])
        mesh->triangles.push_back({v, face});
}

void Tesselate(qcClipMesh* mesh, const qcClipPoint& normal, uint32_t number, const qcClipLoops& loops)
{
    GLUtesselator* tesselator = loops.ends.empty() ? nullptr : gluNewTess();
    if (tesselator == nullptr)
        return;
    Face face{mesh, {}, false};
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
    gluDeleteTess(tesselator);
    for (size_t i = 0; i + 2 < face.corners.size() && !face.failed; i += 3)
        AddTriangle(mesh, {face.corners[i], face.corners[i + 1], face.corners[i + 2]}, number);
}

/// Closes what triangles from a first one on leave open of the edges of loops (without area, or that cross), whatever
/// it looks like: what is open is the edges of loops, with the right signed volume.
void AddFans(qcClipMesh* mesh, size_t first, uint32_t face, const qcClipLoops& loops, qcClipScratch* scratch)
{
    scratch->edges.Clear(loops.points.size());
    for (size_t loop = 0; loop < loops.ends.size(); loop++)
        for (size_t begin = loops.Begin(loop), i = begin, end = loops.ends[loop]; i < end; i++)
            scratch->edges.Add(loops.points[i + 1 < end ? i + 1 : begin], loops.points[i]);
    for (size_t i = first; i < mesh->triangles.size(); i++)
        scratch->edges.Add(mesh->triangles[i].corner);
    scratch->edges.FindLoops(true, &scratch->openLoops);
    const qcClipLoops& open = scratch->openLoops;
    for (size_t loop = 0; loop < open.ends.size(); loop++)
        for (size_t begin = open.Begin(loop), i = begin + 2; i < open.ends[loop]; i++)
            AddTriangle(mesh, {open.points[begin], open.points[i - 1], open.points[i]}, face);
}

//  ---- loops of edges --------------------------------------------------------------------------------

/// One loop that passes each of its points once, as that of nearly every face. False if the edges make no such.
bool FindSimpleLoop(const qcClipArrow* arrows, size_t count, size_t pointCount, qcClipScratch* scratch)
{
    qcClipLoops* loops = &scratch->loops;
    std::vector<uint32_t>& arrowOf = scratch->arrowOf;
    arrowOf.resize(std::max(arrowOf.size(), pointCount));
    for (size_t i = 0; i < count; i++)
        arrowOf[arrows[i].from] = uint32_t(i);
    loops->points.clear();
    loops->ends.clear();
    size_t at = 0;
    do
    {
        loops->points.push_back(arrows[at].from);
        at = arrowOf[arrows[at].to];
    } while (at != 0 && loops->points.size() < count);
    loops->ends.push_back(loops->points.size());
    return at == 0 && loops->points.size() == count;
}

/// Drops points where two edges meet that are between the same two faces: these then go straight on, or lie on each
/// other. A loop may be left with nothing.
void DropBends(const std::vector<uint32_t>& edgesOf, qcClipLoops* loops)
{
    size_t kept = 0, keptLoops = 0, i = 0;
    for (size_t end : loops->ends)
    {
        size_t first = kept;
        for (; i < end; i++)
            if (edgesOf[loops->points[i]] != 2)
                loops->points[kept++] = loops->points[i];
        if (kept - first < 3)
            kept = first;
        else
            loops->ends[keptLoops++] = kept;
    }
    loops->points.resize(kept);
    loops->ends.resize(keptLoops);
}

/// The direction that the loops face, by twice their area.
qcClipPoint NormalOf(const qcClipMesh& mesh, const qcClipLoops& loops)
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
} // namespace

void qcClipFace_Add(qcClipMesh* mesh, uint32_t face, const qcClipArrow* arrows, size_t count, qcClipScratch* scratch)
{
    qcClipLoops& loops = scratch->loops;
    if (!FindSimpleLoop(arrows, count, mesh->points.size(), scratch))
    {
        scratch->edges.Clear(count);
        for (size_t i = 0; i < count; i++)
            scratch->edges.Add(arrows[i].from, arrows[i].to);
        scratch->edges.FindLoops(false, &loops);
    }
    DropBends(scratch->edgesOf, &loops);
    if (loops.ends.empty())
        return;
    if (loops.points.size() == 3)
    {
        AddTriangle(mesh, {loops.points[0], loops.points[1], loops.points[2]}, face);
        return;
    }
    qcClipPoint normal = NormalOf(*mesh, loops);
    bool isSimple = loops.ends.size() == 1 && loops.points.size() <= s_mostCorners;
    if (isSimple && Outline(*mesh, normal, loops, scratch).Triangulate(face, &mesh->triangles))
        return;
    size_t first = mesh->triangles.size();
    Tesselate(mesh, normal, face, loops);
    AddFans(mesh, first, face, loops, scratch);
}
