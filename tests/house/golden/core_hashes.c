// Hashes of the core's results, bit by bit: one line for each scene, question, method and number of threads. Uses the
// public headers only. `core_hashes`: on the CPU, the same results on every machine; lines NAME:work hash what the step
// did on the way to them, which depends on whether the kernels fuse multiply and add. `core_hashes --device`: the
// methods that draw. Lines that begin with # name what the others depend on.
#include "house/golden/core_worlds.h"

#include <assert.h>

static_assert(sizeof(qcPair) == 20 && sizeof(qcSegment) == 48 && sizeof(qcTriangleRef) == 8, "no padding");
static_assert(sizeof(qcProximity) == 88 && sizeof(qcContact) == 112, "no padding");
static_assert(sizeof(qcManifold) == 16 && sizeof(qcManifoldPoint) == 104 && sizeof(qcBoxPair) == 8, "no padding");

static void PrintHash(const char* name, const qcHash* hash)
{
    if (hash->count != 0)
        printf(" %s=%llu:%016llx", name, (unsigned long long)hash->count, (unsigned long long)hash->value);
}

//  ---- scenes ------------------------------------------------------------------------------------------------------

/// All results of a scene's steps.
typedef struct Hashes
{
    qcHash pairs, segments, proximities, contacts, manifolds, points, pcs, work;
} Hashes;

static Hashes Hashes_Start(void)
{
    qcHash start = qcHash_Start();
    return (Hashes){start, start, start, start, start, start, start, start};
}

static void Hashes_Add(Hashes* hashes, const qcResult* r)
{
    qcHash_AddFields(&hashes->pairs, r->pairs, r->pairCount, "44444");
    qcHash_AddFields(&hashes->segments, r->segments, r->segments != NULL ? r->pairCount : 0, "888888");
    qcHash_AddFields(&hashes->proximities, r->proximities, r->proximities != NULL ? r->pairCount : 0, "88888888888");
    qcHash_AddFields(&hashes->contacts, r->contacts, r->contactCount, "444444448888888888");
    qcHash_AddFields(&hashes->manifolds, r->manifolds, r->manifoldCount, "4444");
    qcHash_AddFields(&hashes->points, r->manifoldPoints, r->manifoldPointCount, "8888888888444444");
    qcHash_AddFields(&hashes->pcs, r->pcs, r->pcsCount, "44");
    const qcProfile* p = &r->profile;
    const uint64_t work[] = {p->candidates,
                             p->filterHits,
                             p->exactFallbacks,
                             p->bodyPairs,
                             p->selfBodies,
                             p->trianglePcs,
                             p->objectPcs,
                             p->skippedStaticPairs,
                             p->skippedFilteredPairs,
                             p->skippedSetPairs,
                             p->skippedBodies,
                             p->skippedTriangles,
                             p->reused,
                             p->skippedSetCandidates,
                             p->skippedNeighbours,
                             p->fittedTriangles,
                             p->followedTriangles,
                             p->flatTriangles,
                             p->queries,
                             p->rendered};
    qcHash_AddFields(&hashes->work, work, sizeof work / sizeof work[0], "8");
}

/// A filter for pairs of bodies: one has slot 0, or the sum of slots is even.
static bool FilterPairs(void* context, uint32_t slotA, uint32_t slotB)
{
    (void)context;
    return slotA == 0 || slotB == 0 || (slotA + slotB) % 2 == 0;
}

/// Lengths are shares of the scene's own.
typedef struct Question
{
    const char* name;
    double margin, contactMargin;
    bool touching, neighbours, segments, proximities, manifolds, nearest, filter;
} Question;

static const Question s_questions[] = {
    {.name = "pairs", .segments = true},
    {.name = "touching", .touching = true, .neighbours = true, .proximities = true},
    {.name = "margin", .margin = 0.5, .proximities = true, .filter = true},
    {.name = "manifolds", .margin = 1.0, .segments = true, .proximities = true, .manifolds = true},
    {.name = "overlaps", .touching = true, .manifolds = true},
    {.name = "wide", .margin = 2.0, .manifolds = true},
    {.name = "contacts", .contactMargin = 1.0},
    {.name = "nearest", .margin = 0.25, .contactMargin = 1.5, .nearest = true, .filter = true},
};

enum
{
    qc_questionCount = sizeof s_questions / sizeof s_questions[0]
};

typedef struct SceneKind
{
    const char* name;
    void (*step)(World* world, uint32_t step);
    double length; ///< the unit of margins
    bool small;    ///< small enough for brute force
    bool drawn;    ///< with --device too
} SceneKind;

static const SceneKind s_scenes[] = {
    {"soups", StepSoups, 0.005, true, true},      {"degenerate", StepDegenerate, 0.01, true, true},
    {"far", StepFar, 0.05, true, false},          {"closed", StepClosed, 0.01, false, true},
    {"rest", StepRest, 0.01, false, false},       {"many", StepMany, 0.005, false, false},
    {"folded", StepFolded, 0.004, false, false},  {"twisted", StepTwisted, 0.005, false, false},
    {"tangled", StepTangled, 0.005, false, true}, {"sheets", StepSheets, 0.005, false, false},
    {"draped", StepDraped, 0.01, false, true},
};

/// A method and what it is run with.
typedef struct Run
{
    const char* name;
    qcMethod method;
    uint32_t threads;
    bool exact;  ///< never misses; answers every question
    bool fixed;  ///< candidates don't depend on measured times
    bool quick;  ///< on small scenes only
    bool beyond; ///< reliable, back to front, second pass from the back
} Run;

static const Run s_cpuRuns[] = {
    {.name = "sweep,1", .method = qc_methodSweep, .threads = 1, .exact = true, .fixed = true},
    {.name = "sweep,2", .method = qc_methodSweep, .threads = 2, .exact = true, .fixed = true},
    {.name = "auto,2", .method = qc_methodAuto, .threads = 2, .exact = true, .fixed = true},
    {.name = "brute,2", .method = qc_methodBrute, .threads = 2, .exact = true, .fixed = true, .quick = true},
};

static const Run s_deviceRuns[] = {
    {.name = "layers,1", .method = qc_methodLayers, .threads = 1, .exact = true, .fixed = true},
    {.name = "layers,2", .method = qc_methodLayers, .threads = 2, .exact = true, .fixed = true},
    {.name = "auto,2", .method = qc_methodAuto, .threads = 2, .exact = true},
    {.name = "cullide,1", .method = qc_methodCullide, .threads = 1, .fixed = true},
    {.name = "quick,2", .method = qc_methodQuick, .threads = 2, .fixed = true},
    {.name = "reliable,1", .method = qc_methodQuick, .threads = 1, .fixed = true, .beyond = true},
};

static qcDetectDef DefOf(const Question* question, const Run* run, double length)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = run->method;
    def.threads = run->threads;
    def.margin = run->exact || run->beyond ? question->margin * length : 0.0;
    def.contactMargin = question->contactMargin * length;
    def.touching = question->touching;
    def.neighbours = question->neighbours;
    def.segments = question->segments;
    def.proximities = question->proximities;
    def.manifolds = question->manifolds;
    def.nearestContacts = question->nearest;
    def.pairFilter = question->filter ? FilterPairs : NULL;
    def.resolution = 64;
    def.reliable = def.backToFront = def.secondPassFromBack = run->beyond;
    return def;
}

static void HashScene(qcDevice* device, const SceneKind* kind, const Question* question, const Run* run)
{
    World world = {.random = {0x51c0}};
    qcSceneDef sceneDef = qcDefaultSceneDef();
    sceneDef.device = device;
    CHECK_OK(qcScene_Create(&sceneDef, &world.scene));
    qcDetectDef def = DefOf(question, run, kind->length);
    Hashes hashes = Hashes_Start();
    for (uint32_t step = 0; step < 6; step++)
    {
        kind->step(&world, step);
        const qcResult* result = NULL;
        CHECK_OK(qcScene_Detect(world.scene, &def, &result));
        Hashes_Add(&hashes, result);
    }
    printf("%s/%s/%s", kind->name, question->name, run->name);
    PrintHash("pairs", &hashes.pairs);
    PrintHash("segments", &hashes.segments);
    PrintHash("proximities", &hashes.proximities);
    PrintHash("contacts", &hashes.contacts);
    PrintHash("manifolds", &hashes.manifolds);
    PrintHash("points", &hashes.points);
    if (run->fixed)
    {
        printf("\n%s/%s/%s:work", kind->name, question->name, run->name);
        PrintHash("pcs", &hashes.pcs);
        PrintHash("work", &hashes.work);
    }
    putchar('\n');
    for (uint32_t i = 0; i < world.count; i++)
        qcMesh_Free(&world.meshes[i]);
    qcScene_Destroy(world.scene);
}

static void HashScenes(qcDevice* device, const Run* runs, size_t runCount)
{
    for (size_t s = 0; s < sizeof s_scenes / sizeof s_scenes[0]; s++)
        for (size_t q = 0; q < qc_questionCount; q++)
            for (size_t r = 0; r < runCount; r++)
            {
                const SceneKind* kind = &s_scenes[s];
                const Question* question = &s_questions[q];
                bool refused = question->contactMargin > 0.0 || (question->margin > 0.0 && !runs[r].beyond);
                // With a device some of them; without one, auto is the sweep.
                bool sweep = runs[r].method == qc_methodSweep, first = runs[r].threads == 1;
                bool left = device != NULL ? !kind->drawn || q % 3 != 0 : sweep ? !first && q % 2 == 0 : q % 3 != 0;
                if (!left && (kind->small || !runs[r].quick) && (runs[r].exact || !refused))
                    HashScene(device, kind, question, &runs[r]);
            }
}

//  ---- pairs of triangles ------------------------------------------------------------------------------------------

static void MakeTriangles(qcRandom* random, double triangles[2][9])
{
    uint32_t kind = qcRandom_Below(random, 5);
    double scale = ldexp(1.0, (int)qcRandom_Below(random, 200) - 100);
    for (int i = 0; i < 18; i++)
    {
        double x = qcRandom_Uniform(random, -1.0, 1.0), coarse = (double)qcRandom_Below(random, 4);
        triangles[i / 9][i % 9] = kind == 0   ? x
                                  : kind == 1 ? coarse
                                  : kind == 2 ? (i % 3 == 2 ? 0.5 : x)
                                  : kind == 3 ? coarse + x * 0x1p-45
                                              : x * scale;
    }
    // Some share corners, others have none of their own.
    for (uint32_t n = qcRandom_Below(random, 4); n < 3; n++)
        memcpy(triangles[1] + 3 * qcRandom_Below(random, 3), triangles[0] + 3 * n, 3 * sizeof(double));
}

static void HashTriangles(void)
{
    qcRandom random = {7};
    qcHash relations = qcHash_Start(), proximities = qcHash_Start();
    for (int i = 0; i < 60000; i++)
    {
        double triangles[2][9];
        MakeTriangles(&random, triangles);
        uint32_t relation = (uint32_t)qcRelateTriangles(triangles[0], triangles[1]);
        qcHash_AddFields(&relations, &relation, 1, "4");
        qcProximity proximity;
        double margin = i % 2 == 0 ? qcRandom_Uniform(&random, 0.0, 1.0) : (double)INFINITY;
        bool within = qcTrianglesWithin(triangles[0], triangles[1], margin, &proximity);
        qcHash_AddFields(&proximities, &proximity, within, "88888888888");
    }
    printf("triangles");
    PrintHash("relations", &relations);
    PrintHash("proximities", &proximities);
    putchar('\n');
}

//  ---- boxes -------------------------------------------------------------------------------------------------------

typedef struct Visits
{
    qcHash hash;
    uint32_t left;
    double* fraction;
} Visits;

static bool VisitBox(uint32_t id, void* userData, void* context)
{
    Visits* visits = context;
    uint64_t both[2] = {id, (uint64_t)(uintptr_t)userData};
    qcHash_AddFields(&visits->hash, both, 1, "88");
    if (visits->fraction != NULL)
        *visits->fraction *= 0.9375;
    return --visits->left != 0;
}

static void MakeBounds(qcRandom* random, double size, double lower[3], double upper[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = qcRandom_Uniform(random, 0.0, 1.0);
        upper[axis] = lower[axis] + qcRandom_Uniform(random, 0.0, size);
    }
    if (qcRandom_Below(random, 200) == 0)
        lower[qcRandom_Below(random, 3)] = -(double)INFINITY;
}

enum
{
    qc_boxSlots = 4096
};

/// Boxes of a set, by id.
typedef struct BoxModel
{
    qcBoxes* boxes;
    qcRandom random;
    bool used[qc_boxSlots];
    double lower[qc_boxSlots][3], upper[qc_boxSlots][3];
} BoxModel;

static void ChangeBoxes(BoxModel* model, uint32_t count, uint32_t moves, double size)
{
    qcRandom* random = &model->random;
    while (qcBoxes_GetCount(model->boxes) < count)
    {
        double lower[3], upper[3];
        MakeBounds(random, size, lower, upper);
        uint32_t id;
        CHECK_OK(qcBoxes_Add(model->boxes, lower, upper, (void*)(uintptr_t)qcRandom_Below(random, 1000), &id));
        model->used[id] = true;
        memcpy(model->lower[id], lower, sizeof lower);
        memcpy(model->upper[id], upper, sizeof upper);
    }
    for (uint32_t i = 0; i < moves; i++)
    {
        uint32_t id = qcRandom_Below(random, count), kind = qcRandom_Below(random, 20);
        if (!model->used[id])
            continue;
        if (kind == 0)
        {
            CHECK_OK(qcBoxes_Remove(model->boxes, id));
            model->used[id] = false;
            continue;
        }
        if (kind == 1)
            MakeBounds(random, size, model->lower[id], model->upper[id]);
        for (int axis = 0; axis < 3 && kind > 3; axis++)
        {
            double by = qcRandom_Uniform(random, -0.1, 0.1) * size;
            model->lower[id][axis] += by;
            model->upper[id][axis] += by;
        }
        CHECK_OK(qcBoxes_Move(model->boxes, id, model->lower[id], model->upper[id]));
    }
}

static void QueryBoxes(BoxModel* model, Visits* box, Visits* begun, Visits* cast)
{
    double lower[3], upper[3], to[3], from[3], fraction = 1.0;
    const double none[3] = {0, 0, 0}, wide[3] = {0.01, 0.02, 0.0};
    MakeBounds(&model->random, 0.3, lower, upper);
    MakeBounds(&model->random, 0.3, from, to);
    box->left = 1 + qcRandom_Below(&model->random, 200);
    qcBoxes_QueryBox(model->boxes, lower, upper, VisitBox, box);
    begun->left = UINT32_MAX;
    qcBoxes_QueryBegun(model->boxes, qcRandom_Below(&model->random, qcBoxes_GetCount(model->boxes)), VisitBox, begun);
    cast->left = UINT32_MAX;
    bool shorten = qcRandom_Below(&model->random, 2) != 0;
    cast->fraction = shorten ? &fraction : NULL;
    MakeBounds(&model->random, 0.5, from, upper);
    qcBoxes_CastBox(model->boxes, from, to, none, shorten ? wide : none, cast->fraction, VisitBox, cast);
}

static void HashBoxes(const char* name, uint32_t count, double size)
{
    static BoxModel model;
    memset(&model, 0, sizeof model);
    model.random.state = count;
    CHECK_OK(qcBoxes_Create(&model.boxes));
    Visits start = {.hash = qcHash_Start()}, box = start, begun = start, cast = start;
    qcHash moved = qcHash_Start(), began = moved, ended = moved, bounds = moved, work = moved;
    for (uint32_t step = 0; step < 30; step++)
    {
        // Few, some, all, none.
        const uint32_t moves[4] = {count / 50, count / 4, 2 * count, 0};
        ChangeBoxes(&model, count, moves[step / 2 % 4], size);
        for (int i = 0; i < 8; i++)
            QueryBoxes(&model, &box, &begun, &cast);
        if (step % 5 == 4)
        {
            const qcBoxPair* pairs;
            size_t pairCount;
            CHECK_OK(qcBoxes_FindMovedPairs(model.boxes, &pairs, &pairCount));
            qcHash_AddFields(&moved, pairs, pairCount, "44");
        }
        else
        {
            qcBoxChanges changes;
            CHECK_OK(qcBoxes_FindChangedPairs(model.boxes, &changes));
            qcHash_AddFields(&began, changes.began, changes.beganCount, "44");
            qcHash_AddFields(&ended, changes.ended, changes.endedCount, "44");
        }
        double total[2][3];
        qcBoxes_GetTotalBounds(model.boxes, total[0], total[1]);
        qcHash_AddFields(&bounds, total, 1, "888888");
        qcBoxProfile profile = qcBoxes_GetProfile(model.boxes);
        const uint64_t counters[4] = {profile.moved, profile.sought, profile.compared, profile.sorted};
        qcHash_AddFields(&work, counters, 4, "8");
    }
    qcBoxes_Destroy(model.boxes);
    printf("boxes/%s", name);
    PrintHash("moved", &moved);
    PrintHash("began", &began);
    PrintHash("ended", &ended);
    PrintHash("bounds", &bounds);
    PrintHash("box", &box.hash);
    PrintHash("begun", &begun.hash);
    PrintHash("cast", &cast.hash);
    PrintHash("work", &work);
    putchar('\n');
}

//  ---- main --------------------------------------------------------------------------------------------------------

/// The rule by which the library chooses its kernels. Compilers fuse different products with their sums, which changes
/// the counts of candidates, not the pairs.
static const char* GetKernels(void)
{
#if defined(__x86_64__) || defined(_M_X64)
    const char* choice = getenv("QC_KERNELS");
    if ((choice == NULL || strcmp(choice, "plain") != 0) && __builtin_cpu_supports("avx2") &&
        __builtin_cpu_supports("fma"))
#ifdef __clang__
        return "fused by clang";
#else
        return "fused by gcc";
#endif
#endif
    return "plain";
}

static int HashOnDevice(void)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    qcDevice* device = NULL;
    CHECK_OK(qcDevice_Create(&def, &device));
    qcDeviceInfo info;
    CHECK_OK(qcDevice_GetInfo(device, &info));
    printf("# device %s, %s, %s, kernels %s\n", info.name, info.renderer, info.version, GetKernels());
    if (info.kind != qc_deviceNone)
        HashScenes(device, s_deviceRuns, sizeof s_deviceRuns / sizeof s_deviceRuns[0]);
    qcDevice_Destroy(device);
    return 0;
}

int main(int argc, char** argv)
{
    if (argc == 2 && strcmp(argv[1], "--device") == 0)
        return HashOnDevice();
    if (argc != 1)
    {
        fputs("usage: core_hashes [--device]\n", stderr);
        return 2;
    }
    printf("# kernels %s\n", GetKernels());
    HashTriangles();
    HashBoxes("few", 60, 0.5);
    HashBoxes("some", 700, 0.25);
    HashBoxes("many", 3000, 0.12);
    HashScenes(NULL, s_cpuRuns, sizeof s_cpuRuns / sizeof s_cpuRuns[0]);
    return 0;
}
