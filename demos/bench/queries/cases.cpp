// Meshes and random queries for the benchmark of rays and sweeps.
#include "bench/queries/cases.h"

#include "bench/scenes/scenes.h"
#include "bench/scenes/shapes.h"

#include <LinearMath/btMinMax.h>

#include <cmath>
#include <cstdio>

namespace queries
{
const Case cases[caseCount] = {
    {"ray 1 m", Kind::closestRay, 1, false},
    {"ray 60 m", Kind::closestRay, 60, false},
    {"ray 60 m, no hit", Kind::closestRay, 60, true},
    {"ray 60 m, all hits", Kind::allRays, 60, false},
    {"sphere 1 m", Kind::sphere, 1, false},
    {"sphere 60 m", Kind::sphere, 60, false},
    {"sphere 60 m, no hit", Kind::sphere, 60, true},
    {"box 1 m", Kind::box, 1, false},
    {"box 60 m", Kind::box, 60, false},
    {"capsule 1 m", Kind::capsule, 1, false},
    {"capsule 60 m", Kind::capsule, 60, false},
    {"contactTest of a box", Kind::contact, 0.6, false},
    {"triangles in 0.6 m", Kind::aabb, 0.6, false},
    {"triangles in 6 m", Kind::aabb, 6, false},
};

namespace
{
constexpr double s_side = 60, s_pi = 3.14159265358979323846;

/// Hills of some metres with ridges down to half a metre, over a square.
Mesh MakeHills(uint32_t cells)
{
    Mesh mesh;
    auto height = [](double x, double z)
    {
        double sum = 0;
        const double waves[][3] = {
            {0.11, 0.07, 3}, {-0.05, 0.16, 2}, {0.31, -0.23, 0.8}, {0.7, 0.9, 0.3}, {-2.1, 1.7, 0.08}};
        for (const double* wave : waves)
            sum += wave[2] * std::sin(wave[0] * x + wave[1] * z + 5 * wave[2]);
        return sum;
    };
    for (uint32_t j = 0; j <= cells; j++)
        for (uint32_t i = 0; i <= cells; i++)
        {
            double x = s_side * i / cells - s_side / 2, z = s_side * j / cells - s_side / 2;
            mesh.points.push_back(btVector3(btScalar(x), btScalar(height(x, z)), btScalar(z)));
        }
    for (uint32_t j = 0; j < cells; j++)
        for (uint32_t i = 0; i < cells; i++)
        {
            uint32_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
            mesh.indices.insert(mesh.indices.end(), {a, c, b, b, c, d});
        }
    return mesh;
}

/// A tube along a trefoil knot, in place of a missing bunny.
Mesh MakeKnot(uint32_t around, uint32_t along)
{
    Mesh mesh;
    auto center = [](double t)
    {
        return btVector3(btScalar(std::sin(t) + 2 * std::sin(2 * t)), btScalar(std::cos(t) - 2 * std::cos(2 * t)),
                         btScalar(-std::sin(3 * t)));
    };
    for (uint32_t j = 0; j < along; j++)
    {
        double t = 2 * s_pi * j / along;
        btVector3 way = (center(t + 1e-3) - center(t - 1e-3)).normalized();
        btVector3 side = way.cross(btVector3(0, 0, 1)).normalized(), up = side.cross(way);
        for (uint32_t i = 0; i < around; i++)
        {
            double angle = 2 * s_pi * i / around;
            mesh.points.push_back(center(t) + side * btScalar(0.5 * std::cos(angle)) +
                                  up * btScalar(0.5 * std::sin(angle)));
            uint32_t next = (i + 1) % around, row = j * around, above = (j + 1) % along * around;
            mesh.indices.insert(mesh.indices.end(),
                                {row + i, row + next, above + i, row + next, above + next, above + i});
        }
    }
    return mesh;
}

Mesh MakeBunny()
{
    qcMesh read;
    qcMessage message;
    if (!qcMesh_ReadFile(QC_BUNNY_PATH, qc_meshAsDeclared, &read, &message))
    {
        std::fprintf(stderr, "%s; a knot stands in for the bunny\n", message.text);
        return MakeKnot(70, 500);
    }
    Mesh mesh;
    const float* positions = static_cast<const float*>(read.positions);
    for (size_t i = 0; i < read.vertexCount; i++)
        mesh.points.push_back(btVector3(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]));
    mesh.indices.assign(read.indices, read.indices + 3 * size_t(read.triangleCount));
    qcMesh_Free(&read);
    return mesh;
}

/// Centres the mesh and makes its longest side 60 m.
void Fit(Mesh* mesh)
{
    btVector3 lower = mesh->points[0], upper = lower;
    for (const btVector3& point : mesh->points)
    {
        lower.setMin(point);
        upper.setMax(point);
    }
    btVector3 size = upper - lower;
    btScalar scale = btScalar(s_side) / size[size.maxAxis()];
    for (btVector3& point : mesh->points)
        point = (point - (lower + upper) / 2) * scale;
}

btVector3 RandomDirection(uint64_t* state)
{
    for (;;)
    {
        btVector3 v;
        for (int axis = 0; axis < 3; axis++)
            v[axis] = btScalar(qcBenchShapes_Random(state, -1, 1));
        if (v.length2() > btScalar(0.01) && v.length2() < 1)
            return v.normalized();
    }
}

btVector3 RandomOnSurface(const Mesh& mesh, uint64_t* state)
{
    size_t triangle = size_t(qcBenchShapes_Random(state, 0, double(mesh.indices.size() / 3)));
    const uint32_t* index = &mesh.indices[3 * triangle];
    btScalar u = btScalar(qcBenchShapes_Random(state, 0, 1)), v = btScalar(qcBenchShapes_Random(state, 0, 1));
    if (u + v > 1)
    {
        u = 1 - u;
        v = 1 - v;
    }
    const btVector3& p = mesh.points[index[0]];
    return p + u * (mesh.points[index[1]] - p) + v * (mesh.points[index[2]] - p);
}
} // namespace

const char* NameOfMesh(int mesh)
{
    static const char* const names[meshCount] = {"hills-5k", "bunny-70k", "hills-500k"};
    return names[mesh];
}

Mesh MakeMesh(int mesh)
{
    Mesh made = mesh == bunny70k ? MakeBunny() : MakeHills(mesh == hills5k ? 50 : 500);
    Fit(&made);
    return made;
}

std::vector<Query> MakeQueries(const Mesh& mesh, const Case& kind, uint32_t count)
{
    std::vector<Query> made;
    uint64_t state = 2026;
    btScalar half = btScalar(kind.length / 2);
    for (uint32_t i = 0; i < count; i++)
    {
        btVector3 place = RandomOnSurface(mesh, &state), way = RandomDirection(&state);
        // Long ways are those of a view across the land.
        if (kind.length > 6)
            way = (way * btVector3(1, btScalar(0.2), 1)).normalized();
        // Up to where the hills end.
        if (kind.misses)
            place += btVector3(0, btScalar(qcBenchShapes_Random(&state, 0.5, 4)), 0);
        if (kind.kind == Kind::aabb || kind.kind == Kind::contact)
            way = btVector3(1, 1, 1);
        made.push_back({place - way * half, place + way * half});
    }
    return made;
}
} // namespace queries
