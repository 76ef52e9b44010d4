// Triangle meshes of the scenes of `qc-bench through`.
#include "bench/through/shapes.h"

#include "bench/scenes/scenes.h"
#include "common/mesh_io/decimate.h"
#include "common/mesh_io/mesh_file.h"

#include <algorithm>
#include <cstdio>
#include <map>

uint32_t qcTriangles::Add(const btVector3& p)
{
    positions.insert(positions.end(), {p.x(), p.y(), p.z()});
    return uint32_t(positions.size() / 3 - 1);
}

void qcTriangles::Add(uint32_t a, uint32_t b, uint32_t c)
{
    indices.insert(indices.end(), {a, b, c});
}

std::unique_ptr<qcMeshShape> qcTriangles::MakeShape() const
{
    return std::unique_ptr<qcMeshShape>(new qcMeshShape(positions.data(), qcBulletPositions, 0,
                                                        uint32_t(positions.size() / 3), indices.data(),
                                                        uint32_t(indices.size() / 3)));
}

std::unique_ptr<btTriangleIndexVertexArray> qcTriangles::MakeArray() const
{
    btIndexedMesh part;
    part.m_numTriangles = int(indices.size() / 3);
    part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(indices.data());
    part.m_triangleIndexStride = 3 * int(sizeof(uint32_t));
    part.m_numVertices = int(positions.size() / 3);
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(positions.data());
    part.m_vertexStride = 3 * int(sizeof(btScalar));
    part.m_vertexType = sizeof(btScalar) == sizeof(double) ? PHY_DOUBLE : PHY_FLOAT;
    std::unique_ptr<btTriangleIndexVertexArray> array(new btTriangleIndexVertexArray);
    array->addIndexedMesh(part, PHY_INTEGER);
    return array;
}

namespace
{
/// Adds a grid of `n` by `m` cells, from `corner` along two sides.
void AddGrid(const btVector3& corner, const btVector3& right, const btVector3& up, int n, int m, qcTriangles* mesh)
{
    auto first = uint32_t(mesh->positions.size() / 3);
    for (int j = 0; j <= m; j++)
        for (int i = 0; i <= n; i++)
            mesh->Add(corner + right * (btScalar(i) / btScalar(n)) + up * (btScalar(j) / btScalar(m)));
    for (int j = 0; j < m; j++)
        for (int i = 0; i < n; i++)
        {
            uint32_t a = first + uint32_t(j * (n + 1) + i), b = a + 1, c = a + uint32_t(n) + 1, d = c + 1;
            mesh->Add(a, b, d);
            mesh->Add(a, d, c);
        }
}

/// Adds the quads between rings of `across` vertices; `closed`: the last ring is joined to the first.
void AddRings(uint32_t first, int rings, int across, bool closed, qcTriangles* mesh)
{
    for (int i = 0; i + (closed ? 0 : 1) < rings; i++)
        for (int j = 0; j < across; j++)
        {
            auto at = [&](int ring, int k) { return first + uint32_t(ring % rings * across + k % across); };
            mesh->Add(at(i, j), at(i + 1, j), at(i + 1, j + 1));
            mesh->Add(at(i, j), at(i + 1, j + 1), at(i, j + 1));
        }
}

/// Adds a fan from `tip` to the ring that begins at `first`.
void AddFan(uint32_t tip, uint32_t first, int count, bool reversed, qcTriangles* mesh)
{
    for (int i = 0; i < count; i++)
    {
        uint32_t a = first + uint32_t(i), b = first + uint32_t((i + 1) % count);
        mesh->Add(tip, reversed ? b : a, reversed ? a : b);
    }
}

btVector3 OnCircle(btScalar radius, int i, int count, btScalar z)
{
    btScalar angle = SIMD_2_PI * btScalar(i) / btScalar(count);
    return btVector3(radius * btCos(angle), radius * btSin(angle), z);
}
} // namespace

qcTriangles qcMakeFloor(btScalar half, int cells, btScalar waves)
{
    qcTriangles mesh;
    AddGrid(btVector3(-half, 0, half), btVector3(2 * half, 0, 0), btVector3(0, 0, -2 * half), cells, cells, &mesh);
    for (size_t i = 0; i < mesh.positions.size(); i += 3)
        mesh.positions[i + 1] = waves * btSin(4 * mesh.positions[i]) * btCos(3 * mesh.positions[i + 2]);
    return mesh;
}

qcTriangles qcMakeBox(const btVector3& half)
{
    qcTriangles mesh;
    for (int corner = 0; corner < 8; corner++)
        mesh.Add(btVector3(corner & 1 ? half.x() : -half.x(), corner & 2 ? half.y() : -half.y(),
                           corner & 4 ? half.z() : -half.z()));
    const uint32_t quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const auto& q : quads)
    {
        mesh.Add(q[0], q[1], q[2]);
        mesh.Add(q[0], q[2], q[3]);
    }
    return mesh;
}

qcTriangles qcMakeCylinder(btScalar radius, btScalar halfLength, int sides)
{
    qcTriangles mesh;
    for (btScalar z : {-halfLength, halfLength})
        for (int i = 0; i < sides; i++)
            mesh.Add(OnCircle(radius, i, sides, z));
    AddRings(0, 2, sides, false, &mesh);
    uint32_t tips[] = {mesh.Add(btVector3(0, 0, -halfLength)), mesh.Add(btVector3(0, 0, halfLength))};
    AddFan(tips[0], 0, sides, true, &mesh);
    AddFan(tips[1], uint32_t(sides), sides, false, &mesh);
    return mesh;
}

qcTriangles qcMakeSphere(btScalar radius, int around, int across)
{
    qcTriangles mesh;
    for (int i = 1; i < across; i++)
    {
        btScalar angle = SIMD_PI * btScalar(i) / btScalar(across);
        for (int j = 0; j < around; j++)
            mesh.Add(OnCircle(radius * btSin(angle), j, around, -radius * btCos(angle)));
    }
    AddRings(0, across - 1, around, false, &mesh);
    uint32_t tips[] = {mesh.Add(btVector3(0, 0, -radius)), mesh.Add(btVector3(0, 0, radius))};
    AddFan(tips[0], 0, around, true, &mesh);
    AddFan(tips[1], uint32_t((across - 2) * around), around, false, &mesh);
    return mesh;
}

qcTriangles qcMakeTorus(btScalar radius, btScalar tube, int around, int across)
{
    qcTriangles mesh;
    for (int i = 0; i < around; i++)
        for (int j = 0; j < across; j++)
        {
            btScalar angle = SIMD_2_PI * btScalar(j) / btScalar(across);
            mesh.Add(OnCircle(radius + tube * btCos(angle), i, around, tube * btSin(angle)));
        }
    AddRings(0, around, across, true, &mesh);
    return mesh;
}

qcTriangles qcMakeTetrahedra(btScalar edge, int side, btScalar spacing)
{
    qcTriangles mesh;
    btScalar r = edge / btSqrt(btScalar(8)), middle = btScalar(side - 1) / 2;
    for (int k = 0; k < side * side; k++)
    {
        btVector3 place(spacing * (btScalar(k % side) - middle), 0, spacing * (btScalar(k / side) - middle));
        uint32_t a = mesh.Add(place + btVector3(r, r, r)), b = mesh.Add(place + btVector3(-r, r, -r)),
                 c = mesh.Add(place + btVector3(r, -r, -r)), d = mesh.Add(place + btVector3(-r, -r, r));
        mesh.Add(a, c, b);
        mesh.Add(a, d, c);
        mesh.Add(a, b, d);
        mesh.Add(b, c, d);
    }
    return mesh;
}

qcTriangles qcMakeBin(btScalar half, btScalar height, int cells)
{
    qcTriangles mesh;
    btVector3 x(2 * half, 0, 0), y(0, height, 0), z(0, 0, 2 * half), corner(-half, 0, -half);
    AddGrid(corner, z, x, cells, cells, &mesh);
    AddGrid(corner, x, y, cells, cells, &mesh);
    AddGrid(corner + z, y, x, cells, cells, &mesh);
    AddGrid(corner, y, z, cells, cells, &mesh);
    AddGrid(corner + x, z, y, cells, cells, &mesh);
    return mesh;
}

namespace
{
bool ReadBunny(uint32_t triangleCount, qcTriangles* bunny)
{
    qcMesh mesh, coarse;
    qcMessage message;
    if (!qcMesh_ReadFile(QC_BUNNY_PATH, qc_meshAsDeclared, &mesh, &message))
    {
        std::fprintf(stderr, "%s; tori stand in for bunnies\n", message.text);
        return false;
    }
    bool made = qcMesh_Decimate(&mesh, triangleCount, &coarse);
    if (made)
    {
        const float* positions = static_cast<const float*>(coarse.positions);
        for (size_t i = 0; i < 3 * size_t(coarse.vertexCount); i++)
            bunny->positions.push_back(btScalar(0.5) * btScalar(positions[i]));
        bunny->indices.assign(coarse.indices, coarse.indices + 3 * size_t(coarse.triangleCount));
        qcMesh_Free(&coarse);
    }
    qcMesh_Free(&mesh);
    return made;
}
} // namespace

const qcTriangles& qcMakeBunny(uint32_t triangleCount)
{
    static std::map<uint32_t, qcTriangles> made;
    qcTriangles& bunny = made[triangleCount];
    if (!bunny.indices.empty())
        return bunny;
    if (!ReadBunny(triangleCount, &bunny))
        bunny = qcMakeTorus(btScalar(0.35), btScalar(0.15), 24, 12);
    btTransform frame = bunny.MakeShape()->getMassProperties().principalFrame.inverse();
    for (size_t i = 0; i < bunny.positions.size(); i += 3)
    {
        btVector3 p = frame * btVector3(bunny.positions[i], bunny.positions[i + 1], bunny.positions[i + 2]);
        std::copy_n(&p[0], 3, &bunny.positions[i]);
    }
    return bunny;
}
