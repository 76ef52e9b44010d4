// The works of `qc-bench peers`, by name: cloths and models with themselves, bunnies with each other.
#include "bench/peers/peers.h"

#include "common/files.h"
#include "bench/scenes/piles.h"
#include "bench/scenes/shapes.h"
#include "common/mesh_io/decimate.h"

#include <stdlib.h>

typedef enum Source
{
    source_cloth,
    source_bunny,
    source_dragon
} Source;

typedef struct Recipe
{
    const char* name;
    const char* title;
    qcPeerKind kind;
    Source source;
    uint32_t size; ///< cells on a side of a cloth, or about how many triangles to leave a model; 0: all
    uint32_t bodyCount;
    double wrinkles; ///< of a cloth
} Recipe;

static const Recipe s_recipes[qc_peerWorkCount] = {
    {"cloth-1k", "folded cloth with itself", qc_peerSelf, source_cloth, 22, 1, 1.0},
    {"cloth-20k", "folded cloth with itself", qc_peerSelf, source_cloth, 100, 1, 1.0},
    {"tangle-20k", "tangled cloth with itself", qc_peerSelf, source_cloth, 100, 1, 2.5},
    {"cloth-250k", "folded cloth with itself", qc_peerSelf, source_cloth, 354, 1, 1.0},
    {"cloth-1m", "folded cloth with itself", qc_peerSelf, source_cloth, 707, 1, 1.0},
    {"bunny", "bunny with itself", qc_peerSelf, source_bunny, 0, 1, 0.0},
    {"dragon", "dragon with itself", qc_peerSelf, source_dragon, 0, 1, 0.0},
    {"bunnies-27", "27 decimated bunnies, deforming", qc_peerDeforming, source_bunny, 5000, 27, 0.0},
    {"bunnies-8", "8 bunnies, deforming", qc_peerDeforming, source_bunny, 0, 8, 0.0},
    {"rigid-27", "27 decimated bunnies, rigid", qc_peerRigid, source_bunny, 5000, 27, 0.0},
    {"rigid-8", "8 bunnies, rigid", qc_peerRigid, source_bunny, 0, 8, 0.0},
};

const char* qcPeerWork_Name(int index)
{
    return s_recipes[index].name;
}

const char* qcPeerWork_Title(int index)
{
    return s_recipes[index].title;
}

//  ---- models --------------------------------------------------------------------------------------

/// A model as floats of extent 1, with as many triangles as the recipe says.
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

static qcBenchMade MakeModel(const Recipe* recipe, const qcBenchModels* models, qcMesh* body, qcMessage* message)
{
    switch (recipe->source)
    {
        case source_cloth:
            return qcBenchShapes_MakeCloth(recipe->size, recipe->wrinkles, body) ||
                           qcMessage_Fail(message, "out of memory")
                       ? qc_benchMade
                       : qc_benchFailed;
        case source_bunny:
            if (qcFiles_IsThere(models->bunny))
                return ReadModel(recipe, models->bunny, body, message);
            qcMessage_Fail(message, "%s is not there; the package glmark2-data has it", models->bunny);
            return qc_benchSkipped;
        case source_dragon:
            if (models->dragon != NULL)
                return ReadModel(recipe, models->dragon, body, message);
            qcMessage_Fail(message, "--dragon names no file; tests/dragon.sh fetches one");
            return qc_benchSkipped;
    }
    return qc_benchFailed;
}

//  ---- bodies and frames ---------------------------------------------------------------------------

static bool CopyBodies(const qcMesh* model, qcPeerWork* work, qcMessage* message)
{
    for (uint32_t i = 0; i < work->bodyCount; ++i)
    {
        if (!qcBenchPile_Copy(model, &work->bodies[i]))
            return qcMessage_Fail(message, "out of memory");
        work->triangleCount += model->triangleCount;
    }
    return true;
}

static bool MakeDeforming(qcPeerWork* work, const qcTransform* places)
{
    for (uint32_t i = 0; i < work->bodyCount; ++i)
    {
        if (work->kind != qc_peerSelf)
            qcBenchPile_Put(&work->bodies[i], &places[i], work->bodies[i].positions);
    }
    qcBenchMotion motion = qcBenchMotion_Make(work->bodies, work->bodyCount, work->frameCount);
    work->positions = calloc((size_t)work->frameCount * work->bodyCount, sizeof *work->positions);
    for (uint32_t k = 0; work->positions != NULL && k < work->frameCount * work->bodyCount; ++k)
    {
        const qcMesh* body = &work->bodies[k % work->bodyCount];
        work->positions[k] = malloc((size_t)body->vertexCount * 3 * sizeof(float));
        if (work->positions[k] == NULL)
            return false;
        qcBenchMotion_Deform(&motion, body, k / work->bodyCount, work->positions[k]);
    }
    return work->positions != NULL;
}

static bool MakeRigid(qcPeerWork* work, const qcTransform* places)
{
    // The bodies lie upon each other in local space: the extent of one is what the motion is measured by.
    qcBenchMotion motion = qcBenchMotion_Make(work->bodies, work->bodyCount, work->frameCount);
    work->transforms = calloc((size_t)work->frameCount * work->bodyCount, sizeof *work->transforms);
    for (uint32_t k = 0; work->transforms != NULL && k < work->frameCount * work->bodyCount; ++k)
    {
        uint32_t body = k % work->bodyCount;
        work->transforms[k] = qcBenchMotion_Carry(&motion, &places[body], body, k / work->bodyCount);
    }
    return work->transforms != NULL;
}

bool qcPeerWork_Animate(qcPeerWork* work)
{
    qcTransform* places = calloc(work->bodyCount, sizeof *places);
    if (places == NULL)
        return false;
    qcBenchPile_Place(work->bodyCount, places);
    bool made = work->kind == qc_peerRigid ? MakeRigid(work, places) : MakeDeforming(work, places);
    free(places);
    return made;
}

static qcBenchMade Fill(const Recipe* recipe, const qcBenchModels* models, qcPeerWork* work, qcMessage* message)
{
    qcMesh model;
    qcBenchMade made = MakeModel(recipe, models, &model, message);
    if (made != qc_benchMade)
        return made;
    work->bodies = calloc(work->bodyCount, sizeof *work->bodies);
    bool filled = work->bodies != NULL && CopyBodies(&model, work, message) && qcPeerWork_Animate(work);
    qcMesh_Free(&model);
    if (!filled)
        qcMessage_Fail(message, "out of memory");
    return filled ? qc_benchMade : qc_benchFailed;
}

qcBenchMade qcPeerWork_Make(int index, const qcBenchModels* models, uint32_t frameCount, qcPeerWork* work,
                            qcMessage* message)
{
    const Recipe* recipe = &s_recipes[index];
    *work =
        (qcPeerWork){.index = index, .kind = recipe->kind, .bodyCount = recipe->bodyCount, .frameCount = frameCount};
    qcBenchMade made = Fill(recipe, models, work, message);
    if (made != qc_benchMade)
        qcPeerWork_Free(work);
    return made;
}

void qcPeerWork_Free(qcPeerWork* work)
{
    for (uint32_t i = 0; work->bodies != NULL && i < work->bodyCount; ++i)
        qcMesh_Free(&work->bodies[i]);
    for (uint32_t k = 0; work->positions != NULL && k < work->frameCount * work->bodyCount; ++k)
        free(work->positions[k]);
    free(work->bodies);
    free(work->positions);
    free(work->transforms);
    *work = (qcPeerWork){0};
}
