// Mass properties of triangle meshes: integrals over tetrahedra from a point of the mesh, or over its triangles where
// it is open. Tonon: Explicit exact formulas for the 3-D tetrahedron inertia tensor, 2004; axes by Jacobi's method,
// 1846.
#include "common/mass_properties.h"

#include "common/weld_vertices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace
{
// A closed mesh with less volume, relative to the ball of the same area, has no inside: it is a sheet with two sides.
constexpr double s_minFill = 1e-6;
// Rounding errors of a variance, relative to the sum of the moments, reach about 1e-10 at the volume above.
constexpr double s_rounding = 1e-6;
constexpr double s_pi = 3.14159265358979323846;

typedef std::array<double, 3> Point;

/// True if each edge is used equally often in both directions.
bool IsClosed(const btVector3* vertices, uint32_t vertexCount, const uint32_t* indices, uint32_t triangleCount)
{
    struct Edge
    {
        uint32_t high;
        int direction; ///< 1 or -1
    };
    std::vector<uint32_t> welded = qcFirstAtPosition(vertices, vertexCount);
    std::vector<Edge> edges(3 * size_t(triangleCount));
    std::vector<size_t> ends(size_t(vertexCount) + 1, 0); // of the edges of each lower vertex
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
                sum += edges[i].direction;
            if (sum != 0)
                return false;
        }
    }
    return true;
}

/// Adds a simplex of the given content, with the corners p and, if n is 4, the origin. Over a simplex of n corners the
/// integral of x is its content times the mean of the corners; that of x y is its content / (n (n + 1)) times the sum
/// of x_i y_i over all corners and of x_i y_j over all pairs of them.
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

/// The tensor of a body of mass 1 about a point, which is relative to the origin of the moments. In units.
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

/// True if no variance of positions about the centre of mass is negative, along any direction. Large parts that are
/// inside out make it negative: the centre of mass then lies outside of the other parts.
bool IsBody(const qcMoments& m)
{
    double center[3], tensor[3][3], axes[3][3];
    for (int axis = 0; axis < 3; axis++)
        center[axis] = m.first[axis] / m.mass;
    InertiaAbout(m, center, tensor);
    qcDiagonalize(tensor, axes);
    double sum = tensor[0][0] + tensor[1][1] + tensor[2][2];
    double minVariance = sum / 2 - std::max({tensor[0][0], tensor[1][1], tensor[2][2]});
    return minVariance >= -s_rounding * std::fabs(sum);
}

btMatrix3x3 ToMatrix(const double m[3][3], double factor)
{
    btMatrix3x3 matrix;
    for (int i = 0; i < 3; i++)
        matrix[i].setValue(btScalar(m[i][0] * factor), btScalar(m[i][1] * factor), btScalar(m[i][2] * factor));
    return matrix;
}

/// True if a type holds `number` and its inverse with all digits, or if the value in units is 0.
template <typename Scalar> bool Holds(double inUnits, double number)
{
    return inUnits == 0 || (number >= double(std::numeric_limits<Scalar>::min()) &&
                            number <= double(std::numeric_limits<Scalar>::max()));
}

/// The diagonal of the tensor of a body, from the tensor for mass 1 in units.
btVector3 MomentsOf(const double tensor[3][3], double mass, double unit)
{
    btVector3 diagonal(0, 0, 0);
    for (int i = 0; i < 3; i++)
    {
        double moment = tensor[i][i] * unit * mass * unit;
        diagonal[i] = Holds<btScalar>(tensor[i][i], moment) ? btScalar(moment) : btScalar(0);
    }
    return diagonal;
}

/// The triangles of a mesh relative to its first vertex, in units.
class UnitTriangles
{
  public:
    UnitTriangles(const btVector3* vertices, const uint32_t* indices, uint32_t triangleCount)
        : m_vertices(vertices), m_indices(indices), m_count(triangleCount), m_unit(ChooseUnit()), m_perUnit(1 / m_unit)
    {
    }

    /// Calls function(corners) for each triangle.
    template <typename Function> void ForEach(Function function) const
    {
        const btVector3& origin = GetOrigin();
        for (size_t t = 0; t < m_count; t++)
        {
            Point p[3];
            for (size_t c = 0; c < 3; c++)
                for (size_t axis = 0; axis < 3; axis++)
                    p[c][axis] = double(m_vertices[m_indices[3 * t + c]][int(axis)]) * m_perUnit -
                                 double(origin[int(axis)]) * m_perUnit;
            function(p);
        }
    }

    const btVector3& GetOrigin() const
    {
        return m_vertices[m_indices[0]];
    }
    double GetUnit() const
    {
        return m_unit;
    }

  private:
    /// A power of two between half and all of the largest distance, along an axis, of a vertex from the first one.
    double ChooseUnit() const
    {
        const btVector3& origin = GetOrigin();
        double half = 0; // of the distance, which could overflow
        for (size_t i = 0; i < 3 * size_t(m_count); i++)
            for (int axis = 0; axis < 3; axis++)
                half = std::max(half, std::fabs(double(m_vertices[m_indices[i]][axis]) / 2 - double(origin[axis]) / 2));
        int exponent;
        std::frexp(half, &exponent);
        // The unit and its inverse are finite.
        return half > 0 ? std::ldexp(1, std::min(std::max(exponent, -1000), 1000)) : 1;
    }

    const btVector3* m_vertices;
    const uint32_t* m_indices;
    uint32_t m_count;
    double m_unit, m_perUnit;
};

/// `hasClosedEdges()` is called for meshes with an inside.
template <typename Predicate>
qcMoments Measure(const btVector3* vertices, const uint32_t* indices, uint32_t triangleCount, Predicate hasClosedEdges)
{
    qcMoments moments = {};
    moments.unit = 1;
    if (triangleCount == 0)
        return moments;
    const UnitTriangles triangles(vertices, indices, triangleCount);
    double area = 0;
    triangles.ForEach(
        [&](const Point p[3])
        {
            AddSimplex(p, Determinant(p) / 6, 4, &moments);
            area += Area(p);
        });
    double ball = std::pow(area, 1.5) / (6 * std::sqrt(s_pi));
    bool closed = std::fabs(moments.mass) > s_minFill * ball && IsBody(moments) && hasClosedEdges();
    if (!closed)
    {
        moments = {};
        triangles.ForEach([&](const Point p[3]) { AddSimplex(p, Area(p), 3, &moments); });
    }
    moments.closed = closed;
    moments.area = area;
    moments.unit = triangles.GetUnit();
    for (int axis = 0; axis < 3; axis++)
        moments.origin[axis] = double(triangles.GetOrigin()[axis]);
    return moments;
}
} // namespace

void qcDiagonalize(double m[3][3], double axes[3][3])
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

qcMoments qcMeasureMesh(const btVector3* vertices, uint32_t vertexCount, const uint32_t* indices,
                        uint32_t triangleCount)
{
    return Measure(vertices, indices, triangleCount,
                   [&] { return IsClosed(vertices, vertexCount, indices, triangleCount); });
}

qcMoments qcMeasureSolid(const btVector3* vertices, const uint32_t* indices, uint32_t triangleCount)
{
    return Measure(vertices, indices, triangleCount, [] { return true; });
}

btVector3 qcInertiaAboutOrigin(const qcMoments& moments, double mass)
{
    double point[3], tensor[3][3];
    for (int axis = 0; axis < 3; axis++)
        point[axis] = -moments.origin[axis] / moments.unit;
    InertiaAbout(moments, point, tensor);
    return MomentsOf(tensor, mass, moments.unit);
}

qcMassProperties qcMassPropertiesOf(const qcMoments& moments)
{
    qcMassProperties properties;
    double unit = moments.unit, center[3] = {}, tensor[3][3], axes[3][3];
    for (int axis = 0; axis < 3; axis++)
    {
        if (moments.mass != 0)
            center[axis] = moments.first[axis] / moments.mass;
        properties.center[axis] = btScalar(moments.origin[axis] + center[axis] * unit);
    }
    InertiaAbout(moments, center, tensor);
    // The volume is negative if the triangles face inwards. The sign cancels in all quotients.
    double volume = moments.closed ? std::fabs(moments.mass) : 0;
    double maxMoment = std::max({tensor[0][0], tensor[1][1], tensor[2][2]});
    bool holdsArea = Holds<double>(moments.area, moments.area * unit * unit);
    bool holdsVolume = Holds<double>(volume, volume * unit * unit * unit);
    bool holdsInertia = Holds<btScalar>(maxMoment, maxMoment * unit * unit);
    if (!holdsArea || !holdsVolume || !holdsInertia)
        properties.status = qcFail(qc_statusBadInput, "mass properties of a mesh: the %s is out of range",
                                   !holdsArea     ? "area"
                                   : !holdsVolume ? "volume"
                                                  : "inertia");
    properties.closed = moments.closed;
    properties.area = holdsArea ? moments.area * unit * unit : 0;
    properties.volume = holdsVolume ? volume * unit * unit * unit : 0;
    properties.inertia = ToMatrix(tensor, holdsInertia ? unit * unit : 0);
    qcDiagonalize(tensor, axes);
    properties.principalFrame = btTransform(ToMatrix(axes, 1), properties.center);
    properties.principalInertia = holdsInertia ? MomentsOf(tensor, 1, unit) : btVector3(0, 0, 0);
    return properties;
}
