// Seeded soups, closed meshes and cloth for the golden programs. Only operations that IEEE 754 rounds correctly, so
// that a seed gives the same bits on every machine.
#ifndef QC_GOLDEN_MESHES_H
#define QC_GOLDEN_MESHES_H

#include "house/golden/hash.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Positions are three doubles a vertex. Out of memory ends the program.
typedef struct qcMesh
{
    double* positions;
    uint32_t* indices;
    uint32_t vertexCount, triangleCount;
} qcMesh;

/// Triangles without common vertices, in the unit cube. `lattice` > 0: corners at multiples of 1 / lattice, where many
/// are coplanar, touch, or are degenerate.
qcMesh qcMesh_MakeSoup(qcRandom* random, uint32_t triangleCount, double size, uint32_t lattice);

/// Turns some triangles into points, segments, or triangles that name a vertex twice.
void qcMesh_MakeDegenerate(qcRandom* random, qcMesh* mesh);

/// `columns` * `rows` squares from the origin; `closedColumns`, `closedRows`: joined to a ring in that direction.
qcMesh qcMesh_MakeGrid(uint32_t columns, uint32_t rows, bool closedColumns, bool closedRows);

/// A point of the unit circle; `turn` in 0..4 goes around once.
void qcGetCirclePoint(double turn, double* c, double* s);

qcMesh qcMesh_MakeTorus(double radius, double tube, uint32_t around, uint32_t across);

/// A closed mesh: the faces of a cube of `side` * `side` squares each. `round`: projected onto a sphere.
qcMesh qcMesh_MakeBox(double radius, uint32_t side, bool round);

/// Folds a sheet twice onto itself, layers `gap` apart.
void qcMesh_Fold(qcMesh* mesh, uint32_t side, double gap, double noise, qcRandom* random);

/// Folds a sheet, then turns its rows around its middle line, by up to `turns` quarter turns: distances between turned
/// layers decrease outwards.
void qcMesh_Twist(qcMesh* mesh, uint32_t side, double turns, qcRandom* random);

void qcMesh_Move(qcMesh* mesh, double scale, double x, double y, double z);

void qcMesh_Shake(qcMesh* mesh, qcRandom* random, double noise, uint32_t every);

void qcMesh_Free(qcMesh* mesh);

#ifdef __cplusplus
}
#endif

#endif
