// The scenes of `qc-bench piles`: meshes that fall on each other and come to rest. A scene is a description: a row of
// the table in scenes.cpp.
#ifndef QC_DEMOS_BENCH_PILES_SCENES_H
#define QC_DEMOS_BENCH_PILES_SCENES_H

#include "bench/through/shapes.h"

#include <vector>

/// A body of a scene, 10 kg.
struct qcPilesBody
{
    size_t model; ///< index in qcPilesSetup::models
    btTransform place;
};

/// What a scene consists of, for any kind of shape.
struct qcPilesSetup
{
    std::vector<qcTriangles> models; ///< centre of mass at the origin, principal axes along the axes
    std::vector<qcPilesBody> bodies;
    /// Half the width of a square bin of triangles around the origin; 0: bodies lie on the ground, a plane at y = 0.
    btScalar binHalf = 0;
};

struct qcPilesSceneDef
{
    const char* name;
    const char* title;
    uint32_t steps; ///< by default: a third each falling, settling and at rest
    void (*make)(uint32_t seed, qcPilesSetup* setup);
    /// False: the hulls of its bodies overlap from the beginning, so that convex shapes are left out.
    bool hulls = true;
    bool gimpact = true; ///< false: btGImpactMeshShape would take minutes a step
};

const std::vector<qcPilesSceneDef>& qcPilesScenes();
/// Null: there is none of this name.
const qcPilesSceneDef* qcFindPilesScene(const char* name);

#endif
