// Triangle meshes from files: PLY in its three encodings, Wavefront OBJ.
// Sources: Turk, The PLY Polygon File Format, 1994. Wavefront Technologies, Advanced Visualizer Manual, appendix B1.
//
// Thread-safety: any thread, no state is kept; the locale does not matter.
#ifndef QC_DEMOS_COMMON_MESH_IO_MESH_FILE_H
#define QC_DEMOS_COMMON_MESH_IO_MESH_FILE_H

#include "common/message.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Vertices are numbered exactly as in the file: triangles are neighbours if they share an index.
typedef struct qcMesh
{
    /// Three doubles or three floats a vertex; each is the one nearest to the number in the file. All are finite.
    void* positions;
    bool isDouble;
    uint32_t vertexCount;
    /// Three a triangle, each below `vertexCount`. A polygon is a fan around its first corner. A triangle strip gives
    /// its triangles, all wound the same way, without those that name a vertex twice.
    uint32_t* indices;
    uint32_t triangleCount;
} qcMesh;

typedef enum qcMeshPrecision
{
    /// Doubles where the file declares more than a float holds (PLY: double, int, uint), otherwise floats. OBJ declares
    /// nothing: floats.
    qc_meshAsDeclared = 0,
    /// Doubles; all digits of a number in text are used, whatever type is declared.
    qc_meshDouble = 1
} qcMeshPrecision;

/// Reads a file. On failure the mesh is empty and the message names the file and the line, or in a binary file the
/// element. Never takes more memory than a small multiple of the file's size.
bool qcMesh_ReadFile(const char* path, qcMeshPrecision precision, qcMesh* mesh, qcMessage* message);

/// Reads a file that is in memory, in the manner of qcMesh_ReadFile; `name` stands for the path.
bool qcMesh_ReadBytes(const char* name, const char* bytes, size_t size, qcMeshPrecision precision, qcMesh* mesh,
                      qcMessage* message);

/// Frees the arrays and empties the mesh.
void qcMesh_Free(qcMesh* mesh);

#ifdef __cplusplus
}
#endif

#endif
