// What the breaking scene is made of: a dragon, cut into pieces when it is loaded, and a bunny that falls on it.
#ifndef QC_DEMOS_BREAKING_MODEL_H
#define QC_DEMOS_BREAKING_MODEL_H

#include "quickcullide/bullet_fracture.h"
#include "quickcullide/bullet_mesh.h"

#include <memory>
#include <string>
#include <vector>

struct qcBreakingModelDef
{
    std::string dragon, bunny;         ///< mesh files; empty: a shape of this program's own
    uint32_t dragonTriangles = 250000; ///< a finer mesh is made coarser
    uint32_t bunnyTriangles = 35000;
    uint32_t cells = 900; ///< Voronoi cells of the dragon; about as many pieces
    uint32_t seed = 1;
};

/// A closed mesh, its centre of mass at the origin and its principal axes along the axes.
struct qcBreakingBunny
{
    std::unique_ptr<qcMeshShape> shape;
    btTransform upright = btTransform::getIdentity(); ///< place at which it stands as in the file
    double volume = 0;
    btVector3 inertia{0, 0, 0}; ///< for mass 1
};

struct qcBreakingModel
{
    qcFracture fracture;                              ///< in world space: the dragon stands on y = 0
    std::vector<std::unique_ptr<qcMeshShape>> shapes; ///< of each piece
    std::vector<bool> grounded;                       ///< the piece stands on the ground
    btVector3 lower{0, 0, 0}, upper{0, 0, 0};         ///< box of the dragon
    uint32_t dragonTriangles = 0;
    qcBreakingBunny bunny;
};

/// Reads, scales and cuts. False with a message: a file can't be read, or a mesh has no inside.
bool qcMakeBreakingModel(const qcBreakingModelDef& def, qcBreakingModel* model, std::string* message);

#endif
