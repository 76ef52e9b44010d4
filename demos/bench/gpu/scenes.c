// The scenes of `qc-bench gpu`: cloths with themselves and with each other from 1 K to 1 M triangles, and shapes that
// lie close to each other.
#include "bench/gpu/gpu.h"

#include "bench/scenes/piles.h"
#include "bench/scenes/shapes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct Recipe
{
    const char* name;
    const char* title;
    qcAnimationKind kind;
    uint32_t bodyCount; ///< 0: a scene of bench/scenes/scenes.h
    double wrinkles;    ///< of a cloth
    uint32_t triangles; ///< of a scene in one size
} Recipe;

static const Recipe s_recipes[qc_gpuSceneCount] = {
    {"cloth", "a folded cloth with itself", qc_animatedSelf, 1, 1.0, 0},
    {"tangle", "a tangled cloth with itself", qc_animatedSelf, 1, 2.5, 0},
    {"crowd", "27 folded cloths with each other, deforming", qc_animatedDeforming, 27, 1.0, 0},
    {"pile", "27 folded cloths with each other, rigid", qc_animatedRigid, 27, 1.0, 0},
    {"sheets-1e-3", "two wavy sheets 1e-3 apart", qc_animatedSelf, 0, 0.0, 5184},
    {"sheets-1e-6", "two wavy sheets 1e-6 apart", qc_animatedSelf, 0, 0.0, 5184},
    {"slivers", "needles that cross", qc_animatedSelf, 0, 0.0, 5000},
};

// 92 K: the largest cloth of the paper.
static const uint32_t s_sizes[qc_gpuSizeCount] = {1000, 4000, 20000, 92000, 250000, 1000000};

const char* qcGpuScene_Name(int scene)
{
    return s_recipes[scene].name;
}

const char* qcGpuScene_Title(int scene)
{
    return s_recipes[scene].title;
}

uint32_t qcGpuScene_CountSizes(int scene, const qcGpuOptions* options)
{
    uint32_t count = 0;
    if (s_recipes[scene].triangles != 0)
        return s_recipes[scene].triangles <= options->maxTriangles;
    while (count < qc_gpuSizeCount && s_sizes[count] <= options->maxTriangles)
        ++count;
    return count;
}

/// Cloths that share the triangles equally; several are as large as bench/scenes/piles.h places them.
static bool MakeCloths(const Recipe* recipe, uint32_t triangles, qcAnimation* animation, qcMessage* message)
{
    qcMesh cloth;
    uint32_t side = (uint32_t)lround(sqrt(0.5 * triangles / recipe->bodyCount));
    if (!qcBenchShapes_MakeCloth(side, recipe->wrinkles, &cloth))
        return qcMessage_Fail(message, "out of memory");
    animation->bodies = calloc(recipe->bodyCount, sizeof *animation->bodies);
    bool made = animation->bodies != NULL;
    while (made && animation->bodyCount < recipe->bodyCount)
    {
        qcMesh* body = &animation->bodies[animation->bodyCount];
        made = recipe->bodyCount == 1 ? qcBenchPile_Copy(&cloth, body) : qcBenchPile_Normalize(&cloth, body, message);
        animation->bodyCount += made;
    }
    qcMesh_Free(&cloth);
    return made || qcMessage_Fail(message, "out of memory");
}

/// The bodies of the scene of bench/scenes/scenes.h that has this name.
static bool TakeBodies(const char* name, qcAnimation* animation, qcMessage* message)
{
    int index = 0;
    while (strcmp(qcBenchScene_Name(index), name) != 0)
        ++index;
    static const qcBenchModels none = {NULL, NULL};
    qcBenchScene scene;
    if (qcBenchScene_Make(index, &none, &scene, message) != qc_benchMade)
        return false;
    animation->bodies = scene.bodies;
    animation->bodyCount = scene.bodyCount;
    return true;
}

bool qcGpuScene_Make(int scene, uint32_t size, qcAnimation* animation, qcMessage* message)
{
    const Recipe* recipe = &s_recipes[scene];
    *animation = (qcAnimation){.kind = recipe->kind, .frameCount = qc_gpuFrames};
    bool made = recipe->bodyCount != 0 ? MakeCloths(recipe, s_sizes[size], animation, message)
                                       : TakeBodies(recipe->name, animation, message);
    for (uint32_t i = 0; made && i < animation->bodyCount; ++i)
        animation->triangleCount += animation->bodies[i].triangleCount;
    if (made && !qcAnimation_MakeFrames(animation))
        made = qcMessage_Fail(message, "out of memory");
    if (!made)
        qcAnimation_Free(animation);
    return made;
}
