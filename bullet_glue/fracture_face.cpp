// A face by cutting off ears (Meisters: Polygons have ears, 1975), or by GLU's tesselator (it needs no GL context),
// which takes holes and islands alike, but thousands of instructions a point.
//
// However a loop is triangulated, how often triangles cover a place (those that are turned counted off) is how often
// the loop goes round it. So where each triangle faces the right way they lie side by side.
#include "fracture_face.h"

#include <GL/glu.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace
{
//  ---- one loop --------------------------------------------------------------------------------------

// Ears take about the square of the points: with 50, 100 or 200 of them at most, fracture takes as long.
constexpr size_t s_mostCorners = 200;

/// A loop as the normal sees it.
class Outline
{
  public:
    Outline(const qcClipMesh& mesh, const qcClipPoint& normal, const std::vector<uint32_t>& loop) : m_loop(loop)
    {
        size_t axis = 0;
        for (size_t i = 1; i < 3; i++)
            if (std::fabs(normal[i]) > std::fabs(normal[axis]))
                axis = i;
        size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        if (normal[axis] < 0)
            std::swap(u, v);
        for (uint32_t point : loop)
            m_corners.push_back({mesh.points[point][u], mesh.points[point][v]});
    }

    /// Triangles of corners that all face the right way; none if it finds no such.
    std::vector<std::array<size_t, 3>> Triangulate()
    {
        std::vector<std::array<size_t, 3>> ears;
        std::vector<size_t> left(m_corners.size());
        std::iota(left.begin(), left.end(), size_t(0));
        for (size_t i = 0; i < left.size(); i++)
            if (!(Turn(i, (i + 1) % left.size(), (i + 2) % left.size()) > 0))
                m_inward.push_back((i + 1) % left.size());
        // Round and round: from one corner they would be a fan of slivers.
        for (size_t at = 0, missed = 0; left.size() > 3 && missed < left.size(); at = (at + 1) % left.size())
        {
            size_t tip = (at + 1) % left.size();
            std::array<size_t, 3> ear = {left[at], left[tip], left[(at + 2) % left.size()]};
            missed++;
            if (!IsEar(ear))
                continue;
            ears.push_back(ear);
            m_inward.erase(std::remove(m_inward.begin(), m_inward.end(), left[tip]), m_inward.end());
            left.erase(left.begin() + std::ptrdiff_t(tip));
            missed = 0;
        }
        if (left.size() != 3 || !(Turn(left[0], left[1], left[2]) > 0))
            return {};
        ears.push_back({left[0], left[1], left[2]});
        return ears;
    }

  private:
    /// Twice the area of a triangle, positive if it faces the right way.
    double Turn(size_t a, size_t b, size_t c) const
    {
        const std::array<double, 2>&p = m_corners[a], &q = m_corners[b], &r = m_corners[c];
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    }

    /// Of what is in it the corner furthest in turns inward, and did so from the start.
    bool IsEar(const std::array<size_t, 3>& ear) const
    {
        if (!(Turn(ear[0], ear[1], ear[2]) > 0))
            return false;
        for (size_t k : m_inward)
            if (m_loop[k] != m_loop[ear[0]] && m_loop[k] != m_loop[ear[1]] && m_loop[k] != m_loop[ear[2]] &&
                Turn(ear[0], ear[1], k) >= 0 && Turn(ear[1], ear[2], k) >= 0 && Turn(ear[2], ear[0], k) >= 0)
                return false;
        return true;
    }

    const std::vector<uint32_t>& m_loop;
    std::vector<std::array<double, 2>> m_corners;
    std::vector<size_t> m_inward; ///< corners left that don't turn to the left
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

void Tesselate(qcClipMesh* mesh, const qcClipPoint& normal, uint32_t number, const qcClipLoops& loops)
{
    GLUtesselator* tesselator = loops.empty() ? nullptr : gluNewTess();
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
    for (const std::vector<uint32_t>& loop : loops)
    {
        gluTessBeginContour(tesselator);
        for (uint32_t point : loop)
        {
            GLdouble position[3] = {mesh->points[point][0], mesh->points[point][1], mesh->points[point][2]};
            gluTessVertex(tesselator, position, DataOf(point));
        }
        gluTessEndContour(tesselator);
    }
    gluTessEndPolygon(tesselator);
    gluDeleteTess(tesselator);
    for (size_t i = 0; i + 2 < face.corners.size() && !face.failed; i += 3)
        mesh->triangles.push_back({{face.corners[i], face.corners[i + 1], face.corners[i + 2]}, number});
}

} // namespace

void qcClipFace_AddFans(qcClipMesh* mesh, uint32_t face, const qcClipLoops& loops)
{
    for (const std::vector<uint32_t>& loop : loops)
        for (size_t i = 2; i < loop.size(); i++)
            mesh->triangles.push_back({{loop[0], loop[i - 1], loop[i]}, face});
}

void qcClipFace_Add(qcClipMesh* mesh, const qcClipPoint& normal, uint32_t face, const qcClipLoops& loops)
{
    std::vector<std::array<size_t, 3>> triangles;
    if (loops.size() == 1 && loops[0].size() <= s_mostCorners)
        triangles = Outline(*mesh, normal, loops[0]).Triangulate();
    for (const std::array<size_t, 3>& t : triangles)
        mesh->triangles.push_back({{loops[0][t[0]], loops[0][t[1]], loops[0][t[2]]}, face});
    if (triangles.empty())
        Tesselate(mesh, normal, face, loops);
}
