// Meshes of the ablation scenes.
#include "bench/ablation/shapes.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

std::vector<double> qcAblationMesh::Positions() const
{
    std::vector<double> positions;
    for (const btVector3& v : vertices)
        positions.insert(positions.end(), {double(v.x()), double(v.y()), double(v.z())});
    return positions;
}

void qcAddTiles(qcAblationMesh* mesh, const btVector3& corner, const btVector3& side1, const btVector3& side2, int n)
{
    uint32_t first = uint32_t(mesh->vertices.size()), row = uint32_t(n) + 1;
    for (int j = 0; j <= n; j++)
        for (int i = 0; i <= n; i++)
            mesh->vertices.push_back(corner + side1 * (btScalar(i) / btScalar(n)) +
                                     side2 * (btScalar(j) / btScalar(n)));
    for (uint32_t j = 0; j < uint32_t(n); j++)
        for (uint32_t i = 0; i < uint32_t(n); i++)
        {
            uint32_t a = first + j * row + i;
            mesh->indices.insert(mesh->indices.end(), {a, a + 1, a + row + 1, a, a + row + 1, a + row});
        }
}

qcAblationMesh qcBoxOf(btScalar size, int n)
{
    qcAblationMesh box;
    btVector3 x(size, 0, 0), y(0, size, 0), z(0, 0, size), low(-size / 2, -size / 2, -size / 2), high = -low;
    qcAddTiles(&box, low, y, x, n);
    qcAddTiles(&box, low, z, y, n);
    qcAddTiles(&box, low, x, z, n);
    qcAddTiles(&box, high, -x, -y, n);
    qcAddTiles(&box, high, -y, -z, n);
    qcAddTiles(&box, high, -z, -x, n);
    return box;
}

qcAblationMesh qcTorusOf(btScalar size, btScalar tube)
{
    constexpr uint32_t around = 24, section = 12;
    qcAblationMesh torus;
    for (uint32_t i = 0; i < around; i++)
        for (uint32_t j = 0; j < section; j++)
        {
            btScalar u = SIMD_2_PI * btScalar(i) / around, v = SIMD_2_PI * btScalar(j) / section;
            btScalar r = 1 + tube * std::cos(v);
            torus.vertices.push_back(size * btVector3(r * std::cos(u), tube * std::sin(v), r * std::sin(u)));
            uint32_t next = (i + 1) % around, up = (j + 1) % section;
            uint32_t a = i * section + j, b = next * section + j, c = next * section + up, d = i * section + up;
            torus.indices.insert(torus.indices.end(), {a, c, b, a, d, c});
        }
    return torus;
}

qcAblationMesh qcBinOf(btScalar width, btScalar height)
{
    qcAblationMesh bin;
    btVector3 x(width, 0, 0), y(0, height, 0), z(0, 0, width), corner(-width / 2, 0, -width / 2);
    qcAddTiles(&bin, corner, z, x, 6);
    qcAddTiles(&bin, corner, x, y, 6);
    qcAddTiles(&bin, corner, y, z, 6);
    qcAddTiles(&bin, corner + x, z, y, 6);
    qcAddTiles(&bin, corner + z, y, x, 6);
    return bin;
}

std::vector<qcPiece> qcBreakCube(btScalar size, unsigned cells, unsigned seed)
{
    btVector3 half(size / 2, size / 2, size / 2);
    qcAblationMesh cube = qcBoxOf(size, 2);
    qcFractureDef def;
    def.vertices = cube.vertices;
    def.indices = cube.indices;
    def.sites = qcScatterSites(-half, half, cells, seed);
    qcFracture fracture = qcFracture_Split(def);
    if (fracture.status != qc_statusOk)
    {
        std::fprintf(stderr, "qc-ablation: %s\n", fracture.message.c_str());
        std::exit(1);
    }
    return fracture.pieces;
}

void qcExpectOk(qcStatus status)
{
    if (status == qc_statusOk)
        return;
    std::fprintf(stderr, "qc-ablation: %s\n", qcLastMessage());
    std::exit(1);
}

qcBodyId qcAddRigid(qcScene* scene, const qcAblationMesh& mesh)
{
    std::vector<double> positions = mesh.Positions();
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = positions.data();
    def.positionType = qc_positionF64;
    def.vertexCount = uint32_t(mesh.vertices.size());
    def.indices = mesh.indices.data();
    def.triangleCount = uint32_t(mesh.indices.size() / 3);
    qcBodyId id;
    qcExpectOk(qcScene_AddBody(scene, &def, &id));
    return id;
}
