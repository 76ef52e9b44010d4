// The scenes of the benchmarks, by name: shapes made by rule, bunnies piled up, a model as it is.
#include "bench/scenes/scenes.h"

#include "common/files.h"
#include "bench/scenes/shapes.h"
#include "common/mesh_io/bounds.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum Kind
{
    kind_cloth,
    kind_sheets,
    kind_slivers,
    kind_pile,
    kind_dragon
} Kind;

typedef struct Recipe
{
    const char* name;
    const char* title;
    Kind kind;
    double size; ///< cells on a side, gap, or number of needles
} Recipe;

static const Recipe s_recipes[qc_benchSceneCount] = {
    {"cloth-20k", "folded cloth", kind_cloth, 100.0},        {"cloth-250k", "folded cloth", kind_cloth, 354.0},
    {"cloth-2m", "folded cloth", kind_cloth, 1000.0},        {"pile", "pile of three bunnies", kind_pile, 0.0},
    {"dragon", "dragon with itself", kind_dragon, 0.0},      {"sheets-1e-1", "sheets 1e-1 apart", kind_sheets, 1e-1},
    {"sheets-1e-2", "sheets 1e-2 apart", kind_sheets, 1e-2}, {"sheets-1e-3", "sheets 1e-3 apart", kind_sheets, 1e-3},
    {"sheets-1e-4", "sheets 1e-4 apart", kind_sheets, 1e-4}, {"sheets-1e-5", "sheets 1e-5 apart", kind_sheets, 1e-5},
    {"sheets-1e-6", "sheets 1e-6 apart", kind_sheets, 1e-6}, {"slivers", "crossing slivers", kind_slivers, 5000.0},
};

const char* qcBenchScene_Name(int index)
{
    return s_recipes[index].name;
}

const char* qcBenchScene_Title(int index)
{
    return s_recipes[index].title;
}

bool qcBenchScene_Mark(const char* name, bool marks[qc_benchSceneCount])
{
    size_t length = strlen(name);
    bool any = false;
    for (int i = 0; i < qc_benchSceneCount; ++i)
    {
        const char* whole = s_recipes[i].name;
        if (length == 0 || strncmp(whole, name, length) != 0 || (whole[length] != 0 && whole[length] != '-'))
            continue;
        // "sheets-1e" is a slip, not a family.
        if (whole[length] == '-' && memchr(name, '-', length) != NULL)
            continue;
        marks[i] = any = true;
    }
    return any;
}

//  ---- models --------------------------------------------------------------------------------------

/// The transform of a bunny of extent 1: turned about the vertical axis, then about x, then moved.
typedef struct Place
{
    double heading, lean, x, y, z;
} Place;

/// Two side by side and one on top, each overlapping the others by a few hundredths.
static const Place s_pile[] = {{0.0, 0.0, 0.0, 0.0, 0.0}, {2.1, 0.1, 0.74, 0.0, 0.12}, {4.0, -0.2, 0.36, 0.6, 0.05}};

/// Copies a model to floats, so that the pile consists of stored numbers that have been rounded.
static bool PutBunny(const qcMesh* model, const Place* place, const double lower[3], double extent, qcMesh* bunny)
{
    size_t indexSize = (size_t)model->triangleCount * 3 * sizeof(uint32_t);
    *bunny = (qcMesh){.vertexCount = model->vertexCount, .triangleCount = model->triangleCount};
    float* out = malloc((size_t)model->vertexCount * 3 * sizeof(float));
    bunny->positions = out;
    bunny->indices = malloc(indexSize);
    if (bunny->positions == NULL || bunny->indices == NULL)
        return false;
    memcpy(bunny->indices, model->indices, indexSize);
    double c = cos(place->heading), s = sin(place->heading), cl = cos(place->lean), sl = sin(place->lean);
    for (size_t vertex = 0; vertex < model->vertexCount; ++vertex, out += 3)
    {
        double p[3];
        qcMesh_GetVertex(model, vertex, p);
        for (int i = 0; i < 3; ++i)
            p[i] = (p[i] - lower[i]) / extent - 0.5;
        double x = c * p[0] + s * p[2], z = c * p[2] - s * p[0];
        out[0] = (float)(x + place->x);
        out[1] = (float)(cl * p[1] - sl * z + place->y);
        out[2] = (float)(sl * p[1] + cl * z + place->z);
    }
    return true;
}

bool qcBenchModels_LackBunny(const qcBenchModels* models, qcMessage* message)
{
    if (strcmp(models->bunny, QC_BUNNY_PATH) != 0 || qcFiles_IsThere(QC_BUNNY_PATH))
        return false;
    qcMessage_Fail(message, "%s is not there; the package glmark2-data has it", QC_BUNNY_PATH);
    return true;
}

static qcBenchMade MakePile(const qcBenchModels* models, qcBenchScene* scene, qcMessage* message)
{
    const char* path = models->bunny;
    if (qcBenchModels_LackBunny(models, message))
        return qc_benchSkipped;
    qcMesh model;
    if (!qcMesh_ReadFile(path, qc_meshAsDeclared, &model, message))
        return qc_benchFailed;
    double lower[3], upper[3], extent = qcMesh_FindBox(&model, 1, lower, upper);
    bool made = extent > 0.0 || qcMessage_Fail(message, "%s: all its vertices are one point", path);
    for (uint32_t i = 0; made && i < scene->bodyCount; ++i)
    {
        made = PutBunny(&model, &s_pile[i], lower, extent, &scene->bodies[i]);
        if (!made)
            qcMessage_Fail(message, "out of memory");
    }
    qcMesh_Free(&model);
    return made ? qc_benchMade : qc_benchFailed;
}

static qcBenchMade MakeDragon(const char* path, qcBenchScene* scene, qcMessage* message)
{
    if (path == NULL)
    {
        qcMessage_Fail(message, "--dragon names no file; tests/dragon.sh fetches one");
        return qc_benchSkipped;
    }
    return qcMesh_ReadFile(path, qc_meshAsDeclared, &scene->bodies[0], message) ? qc_benchMade : qc_benchFailed;
}

//  ---- all -----------------------------------------------------------------------------------------

static uint32_t CountBodies(Kind kind)
{
    return kind == kind_sheets ? 2 : kind == kind_pile ? (uint32_t)(sizeof s_pile / sizeof s_pile[0]) : 1;
}

static qcBenchMade MakeBodies(const Recipe* recipe, const qcBenchModels* models, qcBenchScene* scene,
                              qcMessage* message)
{
    bool made = false;
    switch (recipe->kind)
    {
        case kind_cloth: made = qcBenchShapes_MakeCloth((uint32_t)recipe->size, 1.0, &scene->bodies[0]); break;
        case kind_sheets: made = qcBenchShapes_MakeSheets(recipe->size, scene->bodies); break;
        case kind_slivers: made = qcBenchShapes_MakeSlivers((uint32_t)recipe->size, &scene->bodies[0]); break;
        case kind_pile: return MakePile(models, scene, message);
        case kind_dragon: return MakeDragon(models->dragon, scene, message);
    }
    if (!made)
        qcMessage_Fail(message, "out of memory");
    return made ? qc_benchMade : qc_benchFailed;
}

qcBenchMade qcBenchScene_Make(int index, const qcBenchModels* models, qcBenchScene* scene, qcMessage* message)
{
    const Recipe* recipe = &s_recipes[index];
    *scene = (qcBenchScene){.bodyCount = CountBodies(recipe->kind)};
    scene->bodies = calloc(scene->bodyCount, sizeof *scene->bodies);
    qcBenchMade made = qc_benchFailed;
    if (scene->bodies != NULL)
        made = MakeBodies(recipe, models, scene, message);
    else
        qcMessage_Fail(message, "out of memory");
    if (made != qc_benchMade)
    {
        qcBenchScene_Free(scene);
        return made;
    }
    double lower[3], upper[3];
    scene->extent = qcMesh_FindBox(scene->bodies, scene->bodyCount, lower, upper);
    for (uint32_t i = 0; i < scene->bodyCount; ++i)
        scene->triangleCount += scene->bodies[i].triangleCount;
    return made;
}

void qcBenchScene_Free(qcBenchScene* scene)
{
    for (uint32_t i = 0; scene->bodies != NULL && i < scene->bodyCount; ++i)
        qcMesh_Free(&scene->bodies[i]);
    free(scene->bodies);
    *scene = (qcBenchScene){0};
}
