// The scenes of `qc-bench gpu`: cloths with themselves and with each other from 1 K to 4 M triangles, shapes that lie
// close to each other, scenes of `qc-bench peers`, and frames of the paper's scenes.
#include "bench/gpu/gpu.h"

#include "bench/peers/peers.h"
#include "bench/scenes/piles.h"
#include "bench/scenes/shapes.h"
#include "common/files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum Source
{
    source_cloths,   ///< in all sizes
    source_shapes,   ///< the scene of bench/scenes/scenes.h that has this name
    source_peers,    ///< likewise, of bench/peers/peers.h
    source_recording ///< of a demo
} Source;

typedef struct Recipe
{
    const char* name;
    const char* title;
    Source source;
    uint32_t triangles; ///< of a scene in one size
    //  Of cloths:
    qcAnimationKind kind;
    uint32_t bodyCount;
    double wrinkles;
} Recipe;

static const Recipe s_recipes[qc_gpuSceneCount] = {
    {"cloth", "a folded cloth with itself", source_cloths, 0, qc_animatedSelf, 1, 1.0},
    {"tangle", "a tangled cloth with itself", source_cloths, 0, qc_animatedSelf, 1, 2.5},
    {"crowd", "27 folded cloths with each other, deforming", source_cloths, 0, qc_animatedDeforming, 27, 1.0},
    {"pile", "27 folded cloths with each other, rigid", source_cloths, 0, qc_animatedRigid, 27, 1.0},
    {"sheets-1e-3", "two wavy sheets 1e-3 apart", source_shapes, 5184, qc_animatedSelf, 0, 0.0},
    {"sheets-1e-6", "two wavy sheets 1e-6 apart", source_shapes, 5184, qc_animatedSelf, 0, 0.0},
    {"slivers", "needles that cross", source_shapes, 5000, qc_animatedSelf, 0, 0.0},
    {"tangle-92k", "a cloth tangled on a spinning ball with itself", source_peers, 92450, qc_animatedSelf, 0, 0.0},
    {"wrung-80k", "a wrung tube with itself", source_peers, 80000, qc_animatedSelf, 0, 0.0},
    {"dragon", "the dragon with itself", source_peers, 871414, qc_animatedSelf, 0, 0.0},
    {"bunnies-27", "27 decimated bunnies with each other, deforming", source_peers, 135000, qc_animatedSelf, 0, 0.0},
    {"rigid-27", "27 decimated bunnies with each other, rigid", source_peers, 135000, qc_animatedSelf, 0, 0.0},
    {"paper-cloth", "the paper's cloth over a table", source_recording, 20000, qc_animatedSelf, 0, 0.0},
    {"paper-breaking", "the paper's breaking dragon", source_recording, 100000, qc_animatedSelf, 0, 0.0},
    {"paper-leaves", "the paper's leaves", source_recording, 40000, qc_animatedSelf, 0, 0.0},
};

// 92 K: the largest cloth of the paper.
static const uint32_t s_sizes[qc_gpuSizeCount] = {1000, 4000, 20000, 92000, 250000, 1000000, 4000000};

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
static bool TakeShapes(const char* name, qcAnimation* animation, qcMessage* message)
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

static qcBenchMade MakePeers(const char* name, const qcGpuOptions* options, qcAnimation* animation, qcMessage* message)
{
    int index = 0;
    while (strcmp(qcPeerScene_Name(index), name) != 0)
        ++index;
    return qcPeerScene_Make(index, &options->models, qc_gpuFrames, animation, message);
}

static qcBenchMade MakeRecorded(const char* name, const qcGpuOptions* options, qcAnimation* animation,
                                qcMessage* message)
{
    char path[4096];
    const char* demo = name + strlen("paper-");
    snprintf(path, sizeof path, "%s/%s.qcr", options->recordings, demo);
    if (qcFiles_IsThere(path))
        return qcGpuRecorded_Make(path, animation, message);
    qcMessage_Fail(message, "there is no %s; \"qc-%s --record %s\" makes it", path, demo, path);
    return qc_benchSkipped;
}

qcBenchMade qcGpuScene_Make(int scene, uint32_t size, const qcGpuOptions* options, qcAnimation* animation,
                            qcMessage* message)
{
    const Recipe* recipe = &s_recipes[scene];
    *animation = (qcAnimation){.kind = recipe->kind, .frameCount = qc_gpuFrames};
    if (recipe->source == source_peers)
        return MakePeers(recipe->name, options, animation, message);
    if (recipe->source == source_recording)
        return MakeRecorded(recipe->name, options, animation, message);
    bool made = recipe->source == source_cloths ? MakeCloths(recipe, s_sizes[size], animation, message)
                                                : TakeShapes(recipe->name, animation, message);
    for (uint32_t i = 0; made && i < animation->bodyCount; ++i)
        animation->triangleCount += animation->bodies[i].triangleCount;
    if (made && !qcAnimation_MakeFrames(animation))
        made = qcMessage_Fail(message, "out of memory");
    if (!made)
        qcAnimation_Free(animation);
    return made ? qc_benchMade : qc_benchFailed;
}
