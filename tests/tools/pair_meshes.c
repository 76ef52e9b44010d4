// The meshes that the tests of qc-pairs read.
#include "tools/pair_meshes.h"

#include "support/run_program.h"

#include <check.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

TestMesh g_meshes[qc_meshCount];

/// Soups on a coarse lattice, so that triangles also touch, share edges in place and lie in one plane.
static void MakeMeshes(void)
{
    srand(11);
    for (int m = 0; m < qc_meshCount; ++m)
    {
        for (int i = 0; i < qc_vertexCount; ++i)
        {
            for (int axis = 0; axis < 3; ++axis)
                g_meshes[m].positions[i][axis] = (rand() % 13 + (axis == 0 ? 7 * m : 0)) * 0.25;
        }
        for (int t = 0; t < qc_triangleCount; ++t)
        {
            for (int corner = 0; corner < 3; ++corner)
                g_meshes[m].indices[t][corner] = (uint32_t)(rand() % qc_vertexCount);
        }
    }
    // A number that only a double holds: reading it as a float would show.
    g_meshes[1].positions[0][0] += 1e-13;
}

static void WriteMeshes(void)
{
    for (int m = 0; m < qc_meshCount; ++m)
    {
        char name[16];
        snprintf(name, sizeof name, "%d.ply", m);
        FILE* stream = fopen(name, "w");
        ck_assert_ptr_nonnull(stream);
        fprintf(stream,
                "ply\nformat ascii 1.0\nelement vertex %d\nproperty double x\nproperty double y\nproperty double z\n"
                "element face %d\nproperty list uchar int vertex_indices\nend_header\n",
                qc_vertexCount, qc_triangleCount);
        for (int i = 0; i < qc_vertexCount; ++i)
            fprintf(stream, "%.17g %.17g %.17g\n", g_meshes[m].positions[i][0], g_meshes[m].positions[i][1],
                    g_meshes[m].positions[i][2]);
        for (int t = 0; t < qc_triangleCount; ++t)
            fprintf(stream, "3 %u %u %u\n", g_meshes[m].indices[t][0], g_meshes[m].indices[t][1],
                    g_meshes[m].indices[t][2]);
        ck_assert_int_eq(fclose(stream), 0);
    }
}

void EnterWithMeshes(void)
{
    EnterFolder();
    MakeMeshes();
    WriteMeshes();
}

bool AreNeighbours(const uint32_t a[3], const uint32_t b[3])
{
    for (int i = 0; i < 9; ++i)
    {
        if (a[i / 3] == b[i % 3])
            return true;
    }
    return false;
}

void GetTriangles(uint32_t bodyA, uint32_t a, uint32_t bodyB, uint32_t b, double triangles[2][9])
{
    for (int corner = 0; corner < 3; ++corner)
    {
        memcpy(triangles[0] + 3 * corner, g_meshes[bodyA].positions[g_meshes[bodyA].indices[a][corner]],
               3 * sizeof(double));
        memcpy(triangles[1] + 3 * corner, g_meshes[bodyB].positions[g_meshes[bodyB].indices[b][corner]],
               3 * sizeof(double));
    }
}

qcRelation Relate(uint32_t bodyA, uint32_t a, uint32_t bodyB, uint32_t b, double margin)
{
    double triangles[2][9];
    GetTriangles(bodyA, a, bodyB, b, triangles);
    qcRelation relation = qcRelateTriangles(triangles[0], triangles[1]);
    bool isNear =
        relation == qc_relationDisjoint && margin > 0.0 && qcTrianglesWithin(triangles[0], triangles[1], margin, NULL);
    return isNear ? qc_relationNear : relation;
}
