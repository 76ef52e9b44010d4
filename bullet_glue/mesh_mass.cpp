// Mass properties of triangle meshes: integrals over tetrahedra from a point of the mesh, or over its triangles where
// it is open. Tonon: Explicit exact formulas for the 3-D tetrahedron inertia tensor, 2004; axes by Jacobi's method,
// 1846.
#include "mesh_mass.h"

#include "mesh_weld.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

namespace
{
// A closed mesh whose volume is less, by the ball of the same area, has no inside: a sheet with two sides.
constexpr double s_leastFill = 1e-6;
constexpr double s_pi = 3.14159265358979323846;

typedef std::array<double, 3> Point;

/// Is each edge passed as often one way as the other?
bool IsClosed(const btVector3* vertices, uint32_t vertexCount, const uint32_t* indices, uint32_t triangleCount)
{
    struct Edge
    {
        uint32_t high;
        int way;
    };
    std::vector<uint32_t> welded = qcFirstAtPosition(vertices, vertexCount);
    std::vector<Edge> edges(3 * size_t(triangleCount));
    std::vector<size_t> ends(size_t(vertexCount) + 1, 0); // of those of each lower vertex
    auto forEach = [&](auto function)
    {
        for (size_t t = 0; t < triangleCount; t++)
            for (size_t c = 0; c < 3; c++)
            {
                uint32_t from = welded[indices[3 * t + c]], to = welded[indices[3 * t + (c + 1) % 3]];
                if (from != to)
                    function(std::min(from, to), Edge{std::max(from, to), from < to ? 1 : -1});
            }
    };
    forEach([&](uint32_t low, const Edge&) { ends[low + 1]++; });
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    forEach([&](uint32_t low, const Edge& edge) { edges[ends[low]++] = edge; });
    for (size_t low = 0, i = 0; low < vertexCount; low++)
    {
        std::sort(edges.begin() + std::ptrdiff_t(i), edges.begin() + std::ptrdiff_t(ends[low]),
                  [](const Edge& x, const Edge& y) { return x.high < y.high; });
        while (i < ends[low])
        {
            int sum = 0;
            for (uint32_t high = edges[i].high; i < ends[low] && edges[i].high == high; i++)
                sum += edges[i].way;
            if (sum != 0)
                return false;
        }
    }
    return true;
}

/// Adds a simplex of corners p of which the first `corners` count, of the given content; the others are the origin. The
/// integral of x over a simplex of n corners is its content times the mean of the corners, that of x y its content /
/// (n (n + 1)) times the sum of x_i y_i over all corners and of x_i y_j over all pairs of them.
void AddSimplex(const Point p[3], double content, double n, qcMoments* moments)
{
    Point sum = {};
    for (int c = 0; c < 3; c++)
        for (size_t axis = 0; axis < 3; axis++)
            sum[axis] += p[c][axis];
    for (size_t axis = 0; axis < 3; axis++)
        moments->first[axis] += content * sum[axis] / n;
    for (size_t k = 0; k < 6; k++)
    {
        size_t a = k % 3, b = k < 3 ? a : (a + 1) % 3;
        double products = sum[a] * sum[b];
        for (int c = 0; c < 3; c++)
            products += p[c][a] * p[c][b];
        moments->second[k] += content * products / (n * (n + 1));
    }
    moments->mass += content;
}

double Determinant(const Point p[3])
{
    return p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
           p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
}

double Area(const Point p[3])
{
    double u[3], v[3];
    for (size_t axis = 0; axis < 3; axis++)
    {
        u[axis] = p[1][axis] - p[0][axis];
        v[axis] = p[2][axis] - p[0][axis];
    }
    double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2], z = u[0] * v[1] - u[1] * v[0];
    return std::sqrt(x * x + y * y + z * z) / 2;
}

/// Moves the origin of the moments from `from` (in the frame wanted) to 0.
void Shift(const Point& from, qcMoments* m)
{
    for (size_t k = 0; k < 6; k++)
    {
        size_t a = k % 3, b = k < 3 ? a : (a + 1) % 3;
        m->second[k] += m->first[a] * from[b] + m->first[b] * from[a] + m->mass * from[a] * from[b];
    }
    for (size_t axis = 0; axis < 3; axis++)
        m->first[axis] += m->mass * from[axis];
}

/// Rotations that make a symmetric matrix diagonal; their product goes to `axes`, column by column.
void Diagonalize(double m[3][3], double axes[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            axes[i][j] = i == j;
    // Convergence is quadratic: a few sweeps reach the last bit.
    for (int sweep = 0; sweep < 16; sweep++)
        for (int k = 0; k < 3; k++)
        {
            int p = k, q = (k + 1) % 3;
            if (std::fabs(m[p][q]) <= 1e-18 * (std::fabs(m[p][p]) + std::fabs(m[q][q])))
                continue;
            double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
            double t = (theta < 0 ? -1 : 1) / (std::fabs(theta) + std::hypot(theta, 1));
            double c = 1 / std::hypot(t, 1), s = t * c;
            for (int i = 0; i < 3; i++)
            {
                double ip = m[i][p], iq = m[i][q];
                m[i][p] = c * ip - s * iq;
                m[i][q] = s * ip + c * iq;
            }
            for (int i = 0; i < 3; i++)
            {
                double pi = m[p][i], qi = m[q][i];
                m[p][i] = c * pi - s * qi;
                m[q][i] = s * pi + c * qi;
                double ap = axes[i][p], aq = axes[i][q];
                axes[i][p] = c * ap - s * aq;
                axes[i][q] = s * ap + c * aq;
            }
        }
}

void InertiaAbout(const qcMoments& m, const double point[3], double tensor[3][3])
{
    double second[6];
    for (size_t k = 0; k < 6; k++)
    {
        size_t a = k % 3, b = k < 3 ? a : (a + 1) % 3;
        second[k] = m.mass != 0 ? m.second[k] / m.mass - (m.first[a] / m.mass) * point[b] -
                                      (m.first[b] / m.mass) * point[a] + point[a] * point[b]
                                : 0;
    }
    double trace = second[0] + second[1] + second[2];
    for (int i = 0; i < 3; i++)
    {
        tensor[i][i] = trace - second[i];
        tensor[i][(i + 1) % 3] = tensor[(i + 1) % 3][i] = -second[3 + i];
    }
}

btMatrix3x3 ToMatrix(const double m[3][3])
{
    btMatrix3x3 matrix;
    for (int i = 0; i < 3; i++)
        matrix[i].setValue(btScalar(m[i][0]), btScalar(m[i][1]), btScalar(m[i][2]));
    return matrix;
}
} // namespace

qcMoments qcMeasureMesh(const btVector3* vertices, uint32_t vertexCount, const uint32_t* indices,
                        uint32_t triangleCount)
{
    qcMoments moments = {};
    if (triangleCount == 0)
        return moments;
    // Seen from a vertex, so that a mesh far from its origin loses nothing.
    Point origin;
    for (size_t axis = 0; axis < 3; axis++)
        origin[axis] = double(vertices[indices[0]][int(axis)]);
    auto forEach = [&](auto function)
    {
        for (size_t t = 0; t < triangleCount; t++)
        {
            Point p[3];
            for (size_t c = 0; c < 3; c++)
                for (size_t axis = 0; axis < 3; axis++)
                    p[c][axis] = double(vertices[indices[3 * t + c]][int(axis)]) - origin[axis];
            function(p);
        }
    };
    double area = 0;
    forEach(
        [&](const Point p[3])
        {
            AddSimplex(p, Determinant(p) / 6, 4, &moments);
            area += Area(p);
        });
    double ball = std::pow(area, 1.5) / (6 * std::sqrt(s_pi));
    bool closed =
        IsClosed(vertices, vertexCount, indices, triangleCount) && std::fabs(moments.mass) > s_leastFill * ball;
    if (!closed)
    {
        moments = {};
        forEach([&](const Point p[3]) { AddSimplex(p, Area(p), 3, &moments); });
    }
    moments.closed = closed;
    moments.area = area;
    Shift(origin, &moments);
    return moments;
}

btMatrix3x3 qcInertiaAbout(const qcMoments& moments, const double point[3])
{
    double tensor[3][3];
    InertiaAbout(moments, point, tensor);
    return ToMatrix(tensor);
}

qcMassProperties qcMassPropertiesOf(const qcMoments& moments)
{
    qcMassProperties properties;
    properties.closed = moments.closed;
    properties.area = btScalar(moments.area);
    // The sign tells whether the triangles face outwards; it falls out of all quotients.
    properties.volume = moments.closed ? btScalar(std::fabs(moments.mass)) : 0;
    double center[3] = {};
    for (int axis = 0; axis < 3 && moments.mass != 0; axis++)
        center[axis] = moments.first[axis] / moments.mass;
    properties.center.setValue(btScalar(center[0]), btScalar(center[1]), btScalar(center[2]));
    properties.inertia = qcInertiaAbout(moments, center);
    double tensor[3][3], axes[3][3];
    InertiaAbout(moments, center, tensor);
    Diagonalize(tensor, axes);
    properties.principalFrame = btTransform(ToMatrix(axes), properties.center);
    properties.principalInertia.setValue(btScalar(tensor[0][0]), btScalar(tensor[1][1]), btScalar(tensor[2][2]));
    return properties;
}
