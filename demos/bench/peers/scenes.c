// The scenes of `qc-bench peers`, by name: cloths and models with themselves, bunnies with each other.
#include "bench/peers/peers.h"

#include "bench/scenes/piles.h"
#include "bench/scenes/shapes.h"
#include "common/mesh_io/decimate.h"

#include <stdlib.h>

typedef enum Source
{
    source_cloth,
    source_spunCloth,
    source_wrungTube,
    source_coincident,
    source_bunny,
    source_dragon
} Source;

typedef struct Recipe
{
    const char* name;
    const char* title;
    qcAnimationKind kind;
    Source source;
    uint32_t size; ///< cells on a side of a cloth or around a tube, triangles; those to leave a model, about; 0: all
    uint32_t bodyCount;
    double wrinkles; ///< of a cloth
} Recipe;

static const Recipe s_recipes[qc_peerSceneRecipes] = {
    {"cloth-1k", "folded cloth with itself", qc_animatedSelf, source_cloth, 22, 1, 1.0},
    {"cloth-20k", "folded cloth with itself", qc_animatedSelf, source_cloth, 100, 1, 1.0},
    {"tangle-20k", "tangled cloth with itself", qc_animatedSelf, source_cloth, 100, 1, 2.5},
    {"tangle-92k", "cloth tangled on a spinning ball with itself", qc_animatedSelf, source_spunCloth, 215, 1, 0.0},
    {"wrung-80k", "wrung tube with itself", qc_animatedSelf, source_wrungTube, 100, 1, 0.0},
    {"cloth-250k", "folded cloth with itself", qc_animatedSelf, source_cloth, 354, 1, 1.0},
    {"cloth-1m", "folded cloth with itself", qc_animatedSelf, source_cloth, 707, 1, 1.0},
    {"bunny", "bunny with itself", qc_animatedSelf, source_bunny, 0, 1, 0.0},
    {"dragon", "dragon with itself", qc_animatedSelf, source_dragon, 0, 1, 0.0},
    {"coincident-2k", "2000 triangles at one place", qc_animatedSelf, source_coincident, 2000, 1, 0.0},
    {"bunnies-27", "27 decimated bunnies, deforming", qc_animatedDeforming, source_bunny, 5000, 27, 0.0},
    {"bunnies-8", "8 bunnies, deforming", qc_animatedDeforming, source_bunny, 0, 8, 0.0},
    {"rigid-27", "27 decimated bunnies, rigid", qc_animatedRigid, source_bunny, 5000, 27, 0.0},
    {"rigid-8", "8 bunnies, rigid", qc_animatedRigid, source_bunny, 0, 8, 0.0},
    {"cloth-20m", "folded cloth with itself", qc_animatedSelf, source_cloth, 3163, 1, 1.0},
};

const char* qcPeerScene_Name(int index)
{
    return s_recipes[index].name;
}

const char* qcPeerScene_Title(int index)
{
    return s_recipes[index].title;
}

//  ---- models --------------------------------------------------------------------------------------

/// A model as floats of extent 1, with the number of triangles in the recipe.
static qcBenchMade ReadModel(const Recipe* recipe, const char* path, qcMesh* body, qcMessage* message)
{
    qcMesh model, coarse;
    if (!qcMesh_ReadFile(path, qc_meshAsDeclared, &model, message))
        return qc_benchFailed;
    bool made;
    if (recipe->size == 0)
        made = qcBenchPile_Normalize(&model, body, message);
    else
    {
        made = qcMesh_Decimate(&model, recipe->size, &coarse) || qcMessage_Fail(message, "out of memory");
        made = made && qcBenchPile_Normalize(&coarse, body, message);
        qcMesh_Free(&coarse);
    }
    qcMesh_Free(&model);
    return made ? qc_benchMade : qc_benchFailed;
}

static qcBenchMade Report(bool made, qcMessage* message)
{
    return made || qcMessage_Fail(message, "out of memory") ? qc_benchMade : qc_benchFailed;
}

static qcBenchMade MakeModel(const Recipe* recipe, const qcBenchModels* models, qcMesh* body, qcMessage* message)
{
    switch (recipe->source)
    {
        case source_cloth: return Report(qcBenchShapes_MakeCloth(recipe->size, recipe->wrinkles, body), message);
        case source_spunCloth: return Report(qcBenchShapes_MakeSpunCloth(recipe->size, body), message);
        case source_wrungTube: return Report(qcBenchShapes_MakeWrungTube(recipe->size, body), message);
        case source_coincident: return Report(qcBenchShapes_MakeCoincident(recipe->size, body), message);
        case source_bunny:
            if (qcBenchModels_LackBunny(models, message))
                return qc_benchSkipped;
            return ReadModel(recipe, models->bunny, body, message);
        case source_dragon:
            if (models->dragon != NULL)
                return ReadModel(recipe, models->dragon, body, message);
            qcMessage_Fail(message, "--dragon names no file; tests/dragon.sh fetches one");
            return qc_benchSkipped;
    }
    return qc_benchFailed;
}

//  ---- bodies and frames ---------------------------------------------------------------------------

static bool CopyBodies(const qcMesh* model, qcAnimation* animation, qcMessage* message)
{
    for (uint32_t i = 0; i < animation->bodyCount; ++i)
    {
        if (!qcBenchPile_Copy(model, &animation->bodies[i]))
            return qcMessage_Fail(message, "out of memory");
        animation->triangleCount += model->triangleCount;
    }
    return true;
}

static qcBenchMade Fill(const Recipe* recipe, const qcBenchModels* models, qcAnimation* animation, qcMessage* message)
{
    qcMesh model;
    qcBenchMade made = MakeModel(recipe, models, &model, message);
    if (made != qc_benchMade)
        return made;
    animation->bodies = calloc(animation->bodyCount, sizeof *animation->bodies);
    bool filled =
        animation->bodies != NULL && CopyBodies(&model, animation, message) && qcAnimation_MakeFrames(animation);
    qcMesh_Free(&model);
    if (!filled)
        qcMessage_Fail(message, "out of memory");
    return filled ? qc_benchMade : qc_benchFailed;
}

qcBenchMade qcPeerScene_Make(int index, const qcBenchModels* models, uint32_t frameCount, qcAnimation* animation,
                             qcMessage* message)
{
    const Recipe* recipe = &s_recipes[index];
    *animation =
        (qcAnimation){.index = index, .kind = recipe->kind, .bodyCount = recipe->bodyCount, .frameCount = frameCount};
    qcBenchMade made = Fill(recipe, models, animation, message);
    if (made != qc_benchMade)
        qcAnimation_Free(animation);
    return made;
}
