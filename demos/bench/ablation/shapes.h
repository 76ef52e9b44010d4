// Meshes of the ablation scenes.
#ifndef QC_DEMOS_BENCH_ABLATION_SHAPES_H
#define QC_DEMOS_BENCH_ABLATION_SHAPES_H

#include "quickcullide/bullet_fracture.h"
#include "quickcullide/quickcullide.h"

#include <LinearMath/btVector3.h>

#include <cstdint>
#include <vector>

struct qcAblationMesh
{
    std::vector<btVector3> vertices;
    std::vector<uint32_t> indices;

    /// Three numbers a vertex, packed, as qcScene expects them.
    std::vector<double> Positions() const;
};

/// Adds a grid of `n` by `n` squares from `corner` along two sides.
void qcAddTiles(qcAblationMesh* mesh, const btVector3& corner, const btVector3& side1, const btVector3& side2, int n);
/// A box about the origin. Each face is a grid of `n` by `n` squares; faces join without a gap.
qcAblationMesh qcBoxOf(btScalar size, int n);
/// A torus about the y axis with the radii 1 and `tube`, scaled by `size`.
qcAblationMesh qcTorusOf(btScalar size, btScalar tube);
/// A bin of five walls, open at the top, `width` wide inside; the floor is at height 0.
qcAblationMesh qcBinOf(btScalar width, btScalar height);
/// Pieces of a cube, in Voronoi cells. Exits with a message if it can't be split.
std::vector<qcPiece> qcBreakCube(btScalar size, unsigned cells, unsigned seed);
/// Adds a rigid body. Exits with a message on failure.
qcBodyId qcAddRigid(qcScene* scene, const qcAblationMesh& mesh);
/// Ends the program with the last message unless the status is qc_statusOk.
void qcExpectOk(qcStatus status);

#endif
