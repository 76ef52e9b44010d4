// Closed meshes from formulas: a tube around a closed curve, and a ball.
#include "breaking/stand_in.h"

#include <algorithm>
#include <cmath>

namespace
{
constexpr double s_pi = 3.14159265358979323846;

btVector3 Vector(double x, double y, double z)
{
    return btVector3(btScalar(x), btScalar(y), btScalar(z));
}

/// The curve of a trefoil knot, upright.
btVector3 Knot(double t)
{
    return Vector(std::sin(t) + 2 * std::sin(2 * t), std::cos(t) - 2 * std::cos(2 * t), -1.1 * std::sin(3 * t));
}

/// Stands on y = 0, centred in x and z, its longest edge `length`.
void Fit(double length, qcBreakingMesh* mesh)
{
    btVector3 lower = mesh->vertices[0], upper = lower;
    for (const btVector3& vertex : mesh->vertices)
    {
        lower.setMin(vertex);
        upper.setMax(vertex);
    }
    btVector3 extent = upper - lower, origin = (lower + upper) / 2;
    origin.setY(lower.y());
    for (btVector3& vertex : mesh->vertices)
        vertex = (vertex - origin) * (btScalar(length) / extent[extent.maxAxis()]);
}

/// Joins rows of vertices: row i + 1, and column k + 1, follow each other around.
void AddQuads(uint32_t row, uint32_t nextRow, uint32_t columns, qcBreakingMesh* mesh)
{
    for (uint32_t k = 0; k < columns; k++)
    {
        uint32_t a = row + k, b = row + (k + 1) % columns, c = nextRow + k, d = nextRow + (k + 1) % columns;
        for (uint32_t index : {a, c, d, a, d, b})
            mesh->indices.push_back(index);
    }
}
} // namespace

qcBreakingMesh qcStandInDragon(uint32_t triangles, double length)
{
    qcBreakingMesh mesh;
    auto across = uint32_t(std::max(8.0, std::sqrt(triangles / 2.0 / 8))),
         along = std::max(24u, triangles / 2 / across);
    for (uint32_t i = 0; i < along; i++)
    {
        double t = 2 * s_pi * i / along;
        btVector3 center = Knot(t), tangent = (Knot(t + 1e-3) - Knot(t - 1e-3)).normalized();
        btVector3 side = tangent.cross(center).normalized(), up = side.cross(tangent);
        for (uint32_t k = 0; k < across; k++)
        {
            double v = 2 * s_pi * k / across, scale = 1 + 0.06 * std::sin(60 * t) * std::cos(8 * v);
            mesh.vertices.push_back(center + (side * btScalar(std::cos(v)) + up * btScalar(std::sin(v))) *
                                                 btScalar(0.5 * scale));
        }
    }
    for (uint32_t i = 0; i < along; i++)
        AddQuads(i * across, (i + 1) % along * across, across, &mesh);
    Fit(length, &mesh);
    return mesh;
}

qcBreakingMesh qcStandInBunny(uint32_t triangles, double length)
{
    qcBreakingMesh mesh;
    auto rows = uint32_t(std::max(4.0, std::sqrt(triangles / 4.0))), columns = 2 * rows;
    auto at = [](double theta, double phi)
    {
        double r = 1 + 0.12 * std::sin(5 * phi) * std::pow(std::sin(theta), 2) + 0.15 * std::cos(3 * theta);
        return Vector(r * std::sin(theta) * std::cos(phi), r * std::cos(theta), r * std::sin(theta) * std::sin(phi));
    };
    for (uint32_t i = 1; i < rows; i++)
        for (uint32_t k = 0; k < columns; k++)
            mesh.vertices.push_back(at(s_pi * i / rows, -2 * s_pi * k / columns));
    for (uint32_t i = 0; i + 2 < rows; i++)
        AddQuads(i * columns, (i + 1) * columns, columns, &mesh);
    auto top = uint32_t(mesh.vertices.size()), bottom = top + 1, last = (rows - 2) * columns;
    mesh.vertices.push_back(at(0, 0));
    mesh.vertices.push_back(at(s_pi, 0));
    for (uint32_t k = 0; k < columns; k++)
    {
        uint32_t next = (k + 1) % columns;
        for (uint32_t index : {top, k, next, bottom, last + next, last + k})
            mesh.indices.push_back(index);
    }
    Fit(length, &mesh);
    return mesh;
}
