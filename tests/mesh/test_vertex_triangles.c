// Triangles around vertices against a loop over all triangles.
#include "mesh/vertex_triangles.h"
#include "support/check_ok.h"
#include "support/failing_heap.h"
#include "support/soups.h"
#include "support/suite.h"

#include <string.h>

enum
{
    qc_maxVertices = 40,
    qc_maxTriangles = 100
};

typedef struct Mesh
{
    uint32_t indices[3 * qc_maxTriangles];
    size_t triangleCount;
    uint32_t vertexCount;
} Mesh;

/// Random vertices, some the same within a triangle; one triangle of eight is left out.
static Mesh MakeRandom(uint64_t seed)
{
    qcRandom random = {seed};
    Mesh mesh = {.triangleCount = qcRandom_Below(&random, qc_maxTriangles + 1),
                 .vertexCount = 1 + qcRandom_Below(&random, qc_maxVertices)};
    for (size_t i = 0; i < 3 * mesh.triangleCount; i++)
        mesh.indices[i] = qcRandom_Below(&random, mesh.vertexCount);
    for (size_t t = 0; t < mesh.triangleCount; t++)
        if (qcRandom_Below(&random, 8) == 0)
            for (int c = 0; c < 3; c++)
                mesh.indices[3 * t + (size_t)c] = mesh.vertexCount;
    return mesh;
}

static void CheckRow(const qcVertexTriangles* around, const Mesh* mesh, uint32_t vertex)
{
    uint32_t at = QC_AT(uint32_t, around->first, vertex), count = 0;
    for (uint32_t t = 0; t < mesh->triangleCount; t++)
    {
        const uint32_t* v = mesh->indices + 3 * (size_t)t;
        if (v[0] == mesh->vertexCount || (v[0] != vertex && v[1] != vertex && v[2] != vertex))
            continue;
        ck_assert_uint_eq(QC_AT(uint32_t, around->triangles, at + count), t);
        count++;
    }
    ck_assert_uint_eq(qcVertexTriangles_Count(around, vertex), count);
}

START_TEST(each_vertex_lists_its_triangles_once_in_ascending_order)
{
    for (uint64_t seed = 0; seed < 2000; seed++)
    {
        Mesh mesh = MakeRandom(seed);
        qcVertexTriangles around;
        CHECK_OK(qcVertexTriangles_Build(&around, mesh.indices, mesh.triangleCount, mesh.vertexCount));
        ck_assert_uint_eq(QC_AT(uint32_t, around.first, 0), 0);
        ck_assert_uint_eq(QC_AT(uint32_t, around.first, mesh.vertexCount), around.triangles.count);
        for (uint32_t v = 0; v < mesh.vertexCount; v++)
            CheckRow(&around, &mesh, v);
        qcVertexTriangles_Free(&around);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_failed_allocation_leaves_nothing)
{
    const uint32_t indices[] = {0, 1, 2};
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    for (size_t failAt = 1; failAt <= 2; failAt++)
    {
        heap = (qcFailingHeap){0, 0, failAt};
        qcVertexTriangles around;
        memset(&around, 0xff, sizeof around);
        ck_assert_int_eq(qcVertexTriangles_Build(&around, indices, 1, 3), qc_statusOutOfMemory);
        ck_assert_uint_eq(heap.live, 0);
        qcVertexTriangles_Free(&around);
    }
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}
END_TEST

QC_RUN_TESTS("triangles around vertices", each_vertex_lists_its_triangles_once_in_ascending_order,
             a_failed_allocation_leaves_nothing)
