// Mesh readers: any bytes give a mesh that keeps its promises, or a message that names the file. Written out again as
// text, a mesh is read as the same.
#define _POSIX_C_SOURCE 200809L
#include "common/mesh_io/mesh_file.h"
#include "fuzz/fuzz.h"

#include <math.h>
#include <string.h>

static double GetCoordinate(const qcMesh* mesh, size_t at)
{
    return mesh->isDouble ? ((const double*)mesh->positions)[at] : (double)((const float*)mesh->positions)[at];
}

static void CheckMesh(const qcMesh* mesh)
{
    for (size_t i = 0; i < 3 * (size_t)mesh->vertexCount; i++)
        FUZZ_CHECK(isfinite(GetCoordinate(mesh, i)));
    for (size_t i = 0; i < 3 * (size_t)mesh->triangleCount; i++)
        FUZZ_CHECK(mesh->indices[i] < mesh->vertexCount);
}

static void CheckSameMesh(const qcMesh* a, const qcMesh* b)
{
    FUZZ_CHECK(a->vertexCount == b->vertexCount && a->triangleCount == b->triangleCount);
    for (size_t i = 0; i < 3 * (size_t)a->vertexCount; i++)
        FUZZ_CHECK(GetCoordinate(a, i) == GetCoordinate(b, i));
    FUZZ_CHECK(a->triangleCount == 0 ||
               memcmp(a->indices, b->indices, 3 * (size_t)a->triangleCount * sizeof *a->indices) == 0);
}

/// Writes a mesh as text, OBJ or PLY, and reads it.
static void WriteAndRead(const qcMesh* mesh, bool asPly)
{
    char* text = NULL;
    size_t size = 0;
    FILE* file = open_memstream(&text, &size);
    FUZZ_CHECK(file != NULL);
    if (asPly)
        fprintf(file,
                "ply\nformat ascii 1.0\nelement vertex %u\nproperty double x\nproperty double y\nproperty double z\n"
                "element face %u\nproperty list uchar int vertex_indices\nend_header\n",
                mesh->vertexCount, mesh->triangleCount);
    for (size_t v = 0; v < mesh->vertexCount; v++)
        fprintf(file, "%s%.17g %.17g %.17g\n", asPly ? "" : "v ", GetCoordinate(mesh, 3 * v),
                GetCoordinate(mesh, 3 * v + 1), GetCoordinate(mesh, 3 * v + 2));
    for (size_t t = 0; t < mesh->triangleCount; t++)
    {
        const uint32_t *v = mesh->indices + 3 * t, first = asPly ? 0 : 1;
        fprintf(file, "%s %u %u %u\n", asPly ? "3" : "f", v[0] + first, v[1] + first, v[2] + first);
    }
    fclose(file);
    qcMesh again;
    qcMessage message;
    FUZZ_CHECK(qcMesh_ReadBytes(asPly ? "again" : "again.obj", text, size, qc_meshDouble, &again, &message));
    CheckSameMesh(mesh, &again);
    qcMesh_Free(&again);
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    qcMesh meshes[2];
    bool isGood[2], isPly = size >= 3 && memcmp(data, "ply", 3) == 0;
    for (int i = 0; i < 2; i++)
    {
        qcMessage message = {{0}};
        isGood[i] = qcMesh_ReadBytes(isPly ? "name" : "name.obj", (const char*)data, size,
                                     i == 0 ? qc_meshAsDeclared : qc_meshDouble, &meshes[i], &message);
        CheckMesh(&meshes[i]);
        // An OBJ file without a face is refused.
        if (isGood[i] && (i == 0 || meshes[i].triangleCount > 0))
            WriteAndRead(&meshes[i], i == 0);
        else if (!isGood[i])
        {
            FUZZ_CHECK(strncmp(message.text, "name", 4) == 0);
            FUZZ_CHECK(meshes[i].vertexCount == 0 && meshes[i].triangleCount == 0);
        }
    }
    // What a float holds, a double holds.
    FUZZ_CHECK(!isGood[0] || isGood[1]);
    for (int i = 0; i < 2; i++)
        qcMesh_Free(&meshes[i]);
    return 0;
}
