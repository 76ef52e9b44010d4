// The meshes that the tests of qc-pairs read, and the relation of their triangles by the exact test.
#ifndef QC_TESTS_TOOLS_PAIR_MESHES_H
#define QC_TESTS_TOOLS_PAIR_MESHES_H

#include <quickcullide/quickcullide.h>

enum
{
    qc_meshCount = 3,
    qc_vertexCount = 60,
    qc_triangleCount = 70
};

typedef struct TestMesh
{
    double positions[qc_vertexCount][3];
    uint32_t indices[qc_triangleCount][3];
} TestMesh;

extern TestMesh g_meshes[qc_meshCount];

/// Fixture: an empty folder with the meshes as 0.ply, 1.ply and 2.ply.
void EnterWithMeshes(void);

/// True if two triangles share a vertex index.
bool AreNeighbours(const uint32_t a[3], const uint32_t b[3]);
/// The corners of a triangle of each body, nine numbers each.
void GetTriangles(uint32_t bodyA, uint32_t a, uint32_t bodyB, uint32_t b, double triangles[2][9]);
/// The relation. Near: disjoint, and no further apart than the margin.
qcRelation Relate(uint32_t bodyA, uint32_t a, uint32_t bodyB, uint32_t b, double margin);

#endif
