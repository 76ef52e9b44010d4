// The factors of section 5.1.3, each varied on one recorded frame: number and choice of views, order of rendering,
// depth complexity; and the resolution, which bounds the precision.
#include "bench/paper/paper.h"

#include "common/progress.h"
#include "common/stopwatch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum
{
    qc_depthGrid = 512, // points on a side where depth complexity is counted
    qc_maxCopies = 4
};

/// A frame as one body with self-collision.
typedef struct Mesh
{
    double* positions;
    uint32_t* indices;
    uint32_t vertexCount, triangleCount;
} Mesh;

typedef struct Work
{
    const qcPaperOptions* options;
    qcDevice* device;
    qcPaperFactors* factors;
    Mesh frame;
} Work;

//  ---- meshes --------------------------------------------------------------------------------------

static bool MakeMesh(uint32_t vertexCount, uint32_t triangleCount, Mesh* mesh, qcMessage* message)
{
    mesh->positions = malloc((3 * (size_t)vertexCount + 1) * sizeof *mesh->positions);
    mesh->indices = malloc((3 * (size_t)triangleCount + 1) * sizeof *mesh->indices);
    mesh->vertexCount = vertexCount;
    mesh->triangleCount = triangleCount;
    return (mesh->positions != NULL && mesh->indices != NULL) || qcMessage_Fail(message, "out of memory");
}

static void FreeMesh(Mesh* mesh)
{
    free(mesh->positions);
    free(mesh->indices);
    *mesh = (Mesh){0};
}

/// Takes a frame of a recording.
static bool ReadFrame(const char* path, uint32_t frame, Work* work, qcMessage* message)
{
    qcPaperSoup soup = {0};
    qcPaperReplay replay;
    bool more = true, done = qcPaperReplay_Open(path, NULL, &replay, message);
    replay.soup = &soup;
    while (done && more && replay.nextFrame <= frame)
        done = qcPaperReplay_Next(&replay, &more, message);
    if (done && !qcPaperSoup_Collect(&soup))
        done = qcMessage_Fail(message, "out of memory");
    if (done)
        done = MakeMesh(soup.vertexCount, soup.triangleCount, &work->frame, message);
    if (done)
    {
        qcPaperSoup_Place(&soup);
        memcpy(work->frame.positions, soup.positions, 3 * (size_t)soup.vertexCount * sizeof *soup.positions);
        memcpy(work->frame.indices, soup.indices, 3 * (size_t)soup.triangleCount * sizeof *soup.indices);
    }
    qcPaperSoup_Free(&soup);
    qcPaperReplay_Close(&replay);
    return done;
}

/// Copies of a mesh one behind the other along z, with a gap between them.
static bool MakeCopies(const Mesh* mesh, uint32_t count, Mesh* copies, qcMessage* message)
{
    if (!MakeMesh(count * mesh->vertexCount, count * mesh->triangleCount, copies, message))
        return false;
    double lower = INFINITY, upper = -INFINITY;
    for (size_t v = 0; v < mesh->vertexCount; ++v)
    {
        lower = fmin(lower, mesh->positions[3 * v + 2]);
        upper = fmax(upper, mesh->positions[3 * v + 2]);
    }
    for (uint32_t copy = 0; copy < count; ++copy)
    {
        double* positions = copies->positions + 3 * (size_t)copy * mesh->vertexCount;
        memcpy(positions, mesh->positions, 3 * (size_t)mesh->vertexCount * sizeof *positions);
        for (size_t v = 0; v < mesh->vertexCount; ++v)
            positions[3 * v + 2] += copy * 1.05 * (upper - lower);
        for (size_t i = 0; i < 3 * (size_t)mesh->triangleCount; ++i)
            copies->indices[3 * (size_t)copy * mesh->triangleCount + i] = copy * mesh->vertexCount + mesh->indices[i];
    }
    return true;
}

typedef struct Item
{
    double key;
    uint32_t triangle;
} Item;

static int CompareItems(const void* x, const void* y)
{
    const Item *a = x, *b = y;
    if (a->key != b->key)
        return a->key < b->key ? -1 : 1;
    return a->triangle < b->triangle ? -1 : 1;
}

typedef enum Order
{
    order_front, ///< front to back along z
    order_random,
    order_model,
    order_back
} Order;

static bool SortTriangles(const Mesh* mesh, Order order, Mesh* sorted, qcMessage* message)
{
    Item* items = malloc(((size_t)mesh->triangleCount + 1) * sizeof *items);
    if (items == NULL || !MakeMesh(mesh->vertexCount, mesh->triangleCount, sorted, message))
    {
        free(items);
        return qcMessage_Fail(message, "out of memory");
    }
    uint64_t random = 1;
    for (uint32_t t = 0; t < mesh->triangleCount; ++t)
    {
        double depth = 0.0; // grows away from the eye
        for (int corner = 0; corner < 3; ++corner)
            depth += mesh->positions[3 * (size_t)mesh->indices[3 * (size_t)t + (size_t)corner] + 2];
        random = random * 6364136223846793005u + 1442695040888963407u;
        double keys[] = {depth, (double)(random >> 33), t, -depth};
        items[t] = (Item){keys[order], t};
    }
    qsort(items, mesh->triangleCount, sizeof *items, CompareItems);
    memcpy(sorted->positions, mesh->positions, 3 * (size_t)mesh->vertexCount * sizeof *sorted->positions);
    for (size_t t = 0; t < mesh->triangleCount; ++t)
        memcpy(sorted->indices + 3 * t, mesh->indices + 3 * (size_t)items[t].triangle, 3 * sizeof(uint32_t));
    free(items);
    return true;
}

//  ---- depth complexity ----------------------------------------------------------------------------

static double Side(const double* a, const double* b, double x, double y)
{
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
}

static void CountTriangle(double corners[3][2], uint32_t* counts)
{
    double lower[2], upper[2];
    for (int axis = 0; axis < 2; ++axis)
    {
        lower[axis] = fmin(corners[0][axis], fmin(corners[1][axis], corners[2][axis]));
        upper[axis] = fmax(corners[0][axis], fmax(corners[1][axis], corners[2][axis]));
    }
    for (int y = (int)ceil(lower[1]); y <= upper[1] && y < qc_depthGrid; ++y)
        for (int x = (int)ceil(lower[0]); x <= upper[0] && x < qc_depthGrid; ++x)
        {
            double a = Side(corners[0], corners[1], x, y), b = Side(corners[1], corners[2], x, y),
                   c = Side(corners[2], corners[0], x, y);
            if ((a >= 0.0 && b >= 0.0 && c >= 0.0) || (a <= 0.0 && b <= 0.0 && c <= 0.0))
                ++counts[y * qc_depthGrid + x];
        }
}

/// Mean number of triangles over the points of a grid that are covered, seen along an axis; 0 if out of memory.
static double FindDepthComplexity(const Mesh* mesh, char view)
{
    size_t axes[2] = {view == 'x' ? 1 : 0, view == 'z' ? 1 : 2};
    double lower[2] = {INFINITY, INFINITY}, extent = 0.0;
    for (int axis = 0; axis < 2; ++axis)
    {
        double upper = -INFINITY;
        for (size_t v = 0; v < mesh->vertexCount; ++v)
        {
            lower[axis] = fmin(lower[axis], mesh->positions[3 * v + axes[axis]]);
            upper = fmax(upper, mesh->positions[3 * v + axes[axis]]);
        }
        extent = fmax(extent, upper - lower[axis]);
    }
    uint32_t* counts = calloc((size_t)qc_depthGrid * qc_depthGrid, sizeof *counts);
    if (counts == NULL || extent == 0.0)
    {
        free(counts);
        return 0.0;
    }
    for (size_t t = 0; t < mesh->triangleCount; ++t)
    {
        double corners[3][2];
        for (size_t corner = 0; corner < 3; ++corner)
            for (size_t axis = 0; axis < 2; ++axis)
                corners[corner][axis] =
                    (mesh->positions[3 * (size_t)mesh->indices[3 * t + corner] + axes[axis]] - lower[axis]) / extent *
                    (qc_depthGrid - 1);
        CountTriangle(corners, counts);
    }
    double sum = 0.0, covered = 0.0;
    for (size_t i = 0; i < (size_t)qc_depthGrid * qc_depthGrid; ++i)
    {
        sum += counts[i];
        covered += counts[i] != 0;
    }
    free(counts);
    return covered > 0.0 ? sum / covered : 0.0;
}

//  ---- queries -------------------------------------------------------------------------------------

static bool Query(const Work* work, const Mesh* mesh, const qcDetectDef* def, qcPaperFactorRow* row, qcMessage* message)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    sceneDef.device = work->device;
    qcBodyDef body = qcDefaultBodyDef();
    body.positions = mesh->positions;
    body.positionType = qc_positionF64;
    body.vertexCount = mesh->vertexCount;
    body.indices = mesh->indices;
    body.triangleCount = mesh->triangleCount;
    body.deforming = true;
    qcDetectDef exact = qcDefaultDetectDef();
    exact.method = qc_methodSweep;
    qcScene* scene = NULL;
    qcBodyId id;
    const qcResult* result = NULL;
    bool done = qcScene_Create(&sceneDef, &scene) == qc_statusOk && qcScene_AddBody(scene, &body, &id) == qc_statusOk &&
                qcScene_Detect(scene, &exact, &result) == qc_statusOk;
    if (done)
    {
        row->exact = result->pairCount;
        done = qcScene_Detect(scene, def, &result) == qc_statusOk;
    }
    if (done)
    {
        row->triangles = mesh->triangleCount;
        row->depth = FindDepthComplexity(mesh, def->views[0]);
        row->pcs = (uint32_t)result->pcsCount;
        row->ms = result->profile.totalMs;
        row->missed = row->exact - result->pairCount;
    }
    else
        qcMessage_Fail(message, "factors: %s", qcLastMessage());
    qcScene_Destroy(scene);
    return done;
}

/// Adds a row for cullide and for each kind of quick up to `last`.
static bool AddRows(Work* work, const Mesh* mesh, const qcPaperFactorRow* pattern, const char* views,
                    uint32_t resolution, qcPaperMethod last, qcMessage* message)
{
    qcPaperFactors* factors = work->factors;
    for (int method = qc_paperCullide; method <= (int)last; ++method)
    {
        qcPaperFactorRow* row = &factors->rows[factors->rowCount];
        *row = *pattern;
        row->method = (qcPaperMethod)method;
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qcPaperMethods[method].method;
        def.backToFront = qcPaperMethods[method].backToFront;
        def.secondPassFromBack = qcPaperMethods[method].secondPassFromBack;
        def.resolution = resolution;
        def.iterations = work->options->iterations;
        def.threads = work->options->threads;
        snprintf(def.views, sizeof def.views, "%s", views);
        if (!Query(work, mesh, &def, row, message))
            return false;
        qcProgress_Update(++factors->rowCount);
    }
    return true;
}

static bool VaryViews(Work* work, qcMessage* message)
{
    static const char* const views[] = {"x", "y", "z", "xz", "xyz"};
    for (size_t i = 0; i < sizeof views / sizeof views[0]; ++i)
    {
        qcPaperFactorRow row = {.factor = "views", .value = (double)strlen(views[i])};
        snprintf(row.setting, sizeof row.setting, "%s", views[i]);
        if (!AddRows(work, &work->frame, &row, views[i], work->factors->resolution, qc_paperQuick, message))
            return false;
    }
    return true;
}

static bool VaryOrder(Work* work, qcMessage* message)
{
    static const char* const names[] = {"front to back", "random", "as modelled", "back to front"};
    for (int order = order_front; order <= order_back; ++order)
    {
        qcPaperFactorRow row = {.factor = "order", .value = order};
        snprintf(row.setting, sizeof row.setting, "%s", names[order]);
        Mesh sorted = {0};
        bool done = SortTriangles(&work->frame, (Order)order, &sorted, message) &&
                    AddRows(work, &sorted, &row, "z", work->factors->resolution,
                            order == order_back ? qc_paperQuickSortedBack : qc_paperQuick, message);
        FreeMesh(&sorted);
        if (!done)
            return false;
    }
    return true;
}

static bool VaryDepth(Work* work, qcMessage* message)
{
    for (uint32_t count = 1; count <= qc_maxCopies; count *= 2)
    {
        qcPaperFactorRow row = {.factor = "depth", .value = count};
        snprintf(row.setting, sizeof row.setting, "%u cop%s", count, count == 1 ? "y" : "ies");
        Mesh copies = {0};
        bool done = MakeCopies(&work->frame, count, &copies, message) &&
                    AddRows(work, &copies, &row, "z", work->factors->resolution, qc_paperQuickSorted, message);
        FreeMesh(&copies);
        if (!done)
            return false;
    }
    return true;
}

static bool VaryResolution(Work* work, qcMessage* message)
{
    for (uint32_t resolution = 256; resolution <= work->factors->resolution; resolution *= 2)
    {
        qcPaperFactorRow row = {.factor = "resolution", .value = resolution};
        snprintf(row.setting, sizeof row.setting, "%u", resolution);
        if (!AddRows(work, &work->frame, &row, "xz", resolution, qc_paperQuick, message))
            return false;
    }
    return true;
}

bool qcPaper_MeasureFactors(const qcPaperOptions* options, const qcPaperScene* scene, const char* path,
                            const qcPaperRecordingInfo* info, qcDevice* device, qcPaperFactors* factors,
                            qcMessage* message)
{
    Work work = {.options = options, .device = device, .factors = factors};
    *factors = (qcPaperFactors){.scene = scene, .frame = info->frameCount / 6, .resolution = options->resolution};
    bool done = ReadFrame(path, factors->frame, &work, message);
    qcProgress_Begin(0, "factors");
    done = done && VaryViews(&work, message) && VaryOrder(&work, message) && VaryDepth(&work, message) &&
           VaryResolution(&work, message);
    qcProgress_End();
    FreeMesh(&work.frame);
    return done;
}
