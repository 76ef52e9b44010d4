// One scene: lives of bodies in turns with Embree. A life: bodies in, then steps through the frames. After it come
// steps in each of which all bodies are new and lack other triangles.
#include "bench/first/first.h"

#include "bench/peers/pair_hash.h"
#include "common/progress.h"
#include "common/stopwatch.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum
{
    qc_newSteps = 6, ///< with a new topology, in each round
    qc_embreeSteps = 3,
    // In a step with a new topology each so many-th triangle is missing, others in each step.
    qc_holeEvery = 64
};

/// The pairs of a frame, in any order.
typedef struct Pairs
{
    bool known;
    uint64_t count, sum;
} Pairs;

typedef struct Bench
{
    const qcFirstOptions* options;
    const qcAnimation* animation;
    const qcPeerLibrary* embree;
    uint32_t threads;
    qcFirstRow* row;
    Pairs frames[qc_firstMaxSteps], tornFrames[qc_newSteps];
    double add[qc_firstMaxRounds], longest[qc_firstMaxRounds], steady[qc_firstMaxRounds];
    double step[3][qc_firstMaxRounds]; ///< first, second, third
    double torn[qc_firstMaxRounds * qc_newSteps], build[2][qc_firstMaxRounds * qc_embreeSteps];
    uint32_t buildCount, tornCount;
    //  Memory of the steps with a new topology and of Embree.
    qcMesh* tornBodies;
    qcPeerBody* peerBodies;
    qcPeerPose* poses;
} Bench;

static void Compare(Bench* bench, Pairs* known, Pairs found)
{
    if (known->known && (known->count != found.count || known->sum != found.sum))
        bench->row->agrees = false;
    *known = found;
    known->known = true;
}

static Pairs PairsOf(const qcResult* result)
{
    Pairs pairs = {.count = result->pairCount};
    for (size_t i = 0; i < result->pairCount; ++i)
    {
        const qcPair* p = &result->pairs[i];
        pairs.sum += qcHashOfPair(p->bodyA, p->triangleA, p->bodyB, p->triangleB);
    }
    return pairs;
}

static qcDetectDef DetectDef(const Bench* bench)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.threads = bench->threads;
    return def;
}

//  ---- a life --------------------------------------------------------------------------------------

static bool Live(Bench* bench, uint32_t round)
{
    qcAnimatedScene scene;
    const qcDetectDef def = DetectDef(bench);
    uint32_t steps = bench->options->steps, last = steps / 4;
    double times[qc_firstMaxSteps], start = qcStopwatch_NowMs();
    bool ran = qcAnimatedScene_Open(bench->animation, NULL, &scene);
    bench->add[round] = qcStopwatch_NowMs() - start;
    bench->longest[round] = 0.0;
    for (uint32_t i = 0; ran && i < steps; ++i)
    {
        start = qcStopwatch_NowMs();
        ran = qcAnimatedScene_Step(&scene, bench->animation, i, &def);
        times[i] = qcStopwatch_NowMs() - start;
        if (ran)
            Compare(bench, &bench->frames[i], PairsOf(scene.result));
        if (i < 3)
            bench->step[i][round] = times[i];
        if (i > 0 && times[i] > bench->longest[round])
            bench->longest[round] = times[i];
    }
    bench->steady[round] = qcStopwatch_Median(times + steps - last, last);
    qcAnimatedScene_Close(&scene);
    return ran;
}

//  ---- a new topology in each step -------------------------------------------------------------------

/// Leaves out every so many-th triangle.
static void Tear(const Bench* bench, uint32_t step)
{
    for (uint32_t i = 0; i < bench->animation->bodyCount; ++i)
    {
        const qcMesh* mesh = &bench->animation->bodies[i];
        qcMesh* torn = &bench->tornBodies[i];
        torn->triangleCount = 0;
        for (uint32_t t = 0; t < mesh->triangleCount; ++t)
            if (t % qc_holeEvery != step * (qc_holeEvery / qc_newSteps))
                memcpy(torn->indices + 3 * (size_t)torn->triangleCount++, mesh->indices + 3 * (size_t)t,
                       3 * sizeof(uint32_t));
    }
}

static bool Replace(qcScene* scene, const qcAnimation* animation, qcBodyId* ids, bool isFirst)
{
    bool done = true;
    for (uint32_t i = 0; done && i < animation->bodyCount; ++i)
    {
        const qcMesh* mesh = &animation->bodies[i];
        qcBodyDef def = qcDefaultBodyDef();
        def.positions = animation->kind == qc_animatedRigid ? mesh->positions : animation->positions[i];
        def.vertexCount = mesh->vertexCount;
        def.indices = mesh->indices;
        def.triangleCount = mesh->triangleCount;
        def.deforming = animation->kind != qc_animatedRigid;
        if (animation->kind == qc_animatedRigid)
            def.transform = animation->transforms[i];
        def.selfCollision = animation->kind == qc_animatedSelf;
        done = (isFirst || qcScene_RemoveBody(scene, ids[i]) == qc_statusOk) &&
               qcScene_AddBody(scene, &def, &ids[i]) == qc_statusOk;
    }
    return done;
}

/// The animation with torn bodies; its first frame is that of the step.
static qcAnimation TornAt(const Bench* bench, uint32_t step)
{
    qcAnimation torn = *bench->animation;
    size_t first = (size_t)(step % torn.frameCount) * torn.bodyCount;
    torn.bodies = bench->tornBodies;
    torn.positions = torn.positions != NULL ? torn.positions + first : NULL;
    torn.transforms = torn.transforms != NULL ? torn.transforms + first : NULL;
    return torn;
}

static bool TearAndDetect(Bench* bench)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene = NULL;
    const qcDetectDef def = DetectDef(bench);
    qcBodyId* ids = calloc(bench->animation->bodyCount, sizeof *ids);
    bool ran = ids != NULL && qcScene_Create(&sceneDef, &scene) == qc_statusOk;
    for (uint32_t step = 0; ran && step < qc_newSteps; ++step)
    {
        const qcResult* result;
        Tear(bench, step);
        qcAnimation torn = TornAt(bench, step);
        double start = qcStopwatch_NowMs();
        ran = Replace(scene, &torn, ids, step == 0) && qcScene_Detect(scene, &def, &result) == qc_statusOk;
        // The first of them allocates.
        if (step > 0)
            bench->torn[bench->tornCount++] = qcStopwatch_NowMs() - start;
        if (ran)
            Compare(bench, &bench->tornFrames[step], PairsOf(result));
    }
    qcScene_Destroy(scene);
    free(ids);
    return ran;
}

//  ---- Embree --------------------------------------------------------------------------------------

static bool BuildWithEmbree(Bench* bench, uint32_t method, double* times)
{
    const qcAnimation* animation = bench->animation;
    const qcPeerTask task = {bench->peerBodies, animation->bodyCount, animation->kind == qc_animatedSelf,
                             bench->threads};
    for (uint32_t i = 0; i < animation->bodyCount; ++i)
        bench->poses[i] = (qcPeerPose){animation->positions[i], NULL};
    void* state = bench->embree->open(&task, method, bench->poses);
    bool ran = state != NULL;
    for (uint32_t i = 0; ran && i < qc_embreeSteps; ++i)
    {
        qcPeerAnswer answer;
        double start = qcStopwatch_NowMs();
        ran = bench->embree->step(state, bench->poses, &answer);
        times[i] = qcStopwatch_NowMs() - start;
        if (!ran)
            break;
        Pairs found = {.count = answer.count};
        for (size_t k = 0; k < answer.count; ++k)
        {
            const qcPeerPair* p = &answer.pairs[k];
            found.sum += qcHashOfPair(p->bodyA, p->triangleA, p->bodyB, p->triangleB);
        }
        Compare(bench, &bench->frames[0], found);
    }
    if (state != NULL)
        bench->embree->close(state);
    return ran;
}

/// Both ways to build anew. Rigid bodies have none: Embree keeps their trees, too.
static bool BuildBoth(Bench* bench)
{
    bool ran = true;
    for (uint32_t m = 0, way = 0; ran && bench->embree != NULL && m < bench->embree->methodCount; ++m)
    {
        const char* name = bench->embree->methods[m].name;
        if (bench->animation->positions == NULL ||
            (strcmp(name, "embree-rebuild") != 0 && strcmp(name, "embree-medium") != 0))
            continue;
        ran = BuildWithEmbree(bench, m, bench->build[way++] + bench->buildCount);
    }
    bench->buildCount += qc_embreeSteps;
    return ran;
}

//  ---- all -----------------------------------------------------------------------------------------

static bool Prepare(Bench* bench)
{
    const qcAnimation* animation = bench->animation;
    bench->tornBodies = calloc(animation->bodyCount, sizeof *bench->tornBodies);
    bench->peerBodies = calloc(animation->bodyCount, sizeof *bench->peerBodies);
    bench->poses = calloc(animation->bodyCount, sizeof *bench->poses);
    bool made = bench->tornBodies != NULL && bench->peerBodies != NULL && bench->poses != NULL;
    for (uint32_t i = 0; made && i < animation->bodyCount; ++i)
    {
        const qcMesh* mesh = &animation->bodies[i];
        bench->peerBodies[i] = (qcPeerBody){mesh->indices, mesh->vertexCount, mesh->triangleCount};
        bench->tornBodies[i] = *mesh;
        bench->tornBodies[i].indices = malloc(3 * (size_t)mesh->triangleCount * sizeof(uint32_t));
        made = bench->tornBodies[i].indices != NULL;
    }
    return made;
}

static void Free(Bench* bench)
{
    for (uint32_t i = 0; bench->tornBodies != NULL && i < bench->animation->bodyCount; ++i)
        free(bench->tornBodies[i].indices);
    free(bench->tornBodies);
    free(bench->peerBodies);
    free(bench->poses);
}

static void Finish(Bench* bench)
{
    qcFirstRow* row = bench->row;
    uint32_t rounds = bench->options->rounds;
    row->addMs = qcStopwatch_Median(bench->add, rounds);
    row->firstMs = qcStopwatch_Median(bench->step[0], rounds);
    row->secondMs = qcStopwatch_Median(bench->step[1], rounds);
    row->thirdMs = qcStopwatch_Median(bench->step[2], rounds);
    row->longestMs = qcStopwatch_Median(bench->longest, rounds);
    row->steadyMs = qcStopwatch_Median(bench->steady, rounds);
    row->newMs = qcStopwatch_Median(bench->torn, bench->tornCount);
    for (int way = 0; way < 2; ++way)
    {
        double ms = qcStopwatch_Median(bench->build[way], bench->buildCount);
        row->embreeMs = ms > 0.0 && (way == 0 || ms < row->embreeMs) ? ms : row->embreeMs;
    }
    row->pairs = bench->frames[0].count;
}

bool qcFirst_Measure(const qcFirstOptions* options, const qcAnimation* animation, const qcPeerLibrary* embree,
                     uint32_t threads, qcFirstRow* row, qcMessage* message)
{
    char label[64];
    *row = (qcFirstRow){
        .scene = animation->index, .triangleCount = animation->triangleCount, .threads = threads, .agrees = true};
    Bench* bench = calloc(1, sizeof *bench);
    if (bench == NULL)
        return qcMessage_Fail(message, "out of memory");
    *bench = (Bench){.options = options, .animation = animation, .embree = embree, .threads = threads, .row = row};
    snprintf(label, sizeof label, "%s, threads: %u", qcPeerScene_Name(animation->index), threads);
    bool ran = Prepare(bench) || qcMessage_Fail(message, "out of memory");
    if (ran)
    {
        qcProgress_Begin(options->rounds, label);
        for (uint32_t round = 0; ran && round < options->rounds; ++round)
        {
            qcStopwatch_Rest();
            ran = Live(bench, round) && TearAndDetect(bench);
            if (!ran)
                qcMessage_Fail(message, "%s: %s", qcPeerScene_Name(animation->index), qcLastMessage());
            qcStopwatch_Rest();
            if (ran && !BuildBoth(bench))
                ran = qcMessage_Fail(message, "%s: Embree failed", qcPeerScene_Name(animation->index));
            qcProgress_Update(round + 1);
        }
        qcProgress_End();
        Finish(bench);
    }
    Free(bench);
    free(bench);
    return ran;
}
