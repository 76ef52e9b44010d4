// All methods on one scene in one run. They take turns: in each round each goes through the frames once, so that a
// disturbance of the machine slows all methods. The first frame of a turn brings a method's data back into the caches
// and is not timed.
#include "bench/peers/peers.h"

#include "bench/peers/pair_hash.h"
#include "common/stopwatch.h"
#include "common/progress.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum
{
    // A turn with slow frames ends here: more frames would hardly change the median.
    qc_minTimed = 2,
    // A new body's topology is worked out in parts, one a step, in at most as many steps.
    qc_settlingSteps = 30
};

// The time limit of one turn.
static const double s_enoughMs = 400.0;

/// A method that is being measured.
typedef struct Runner
{
    qcPeerRow* row;
    qcAnimatedScene ours; ///< for this library's methods; for a peer:
    void* state;
    qcPeerAnswer answer;
    uint32_t next; ///< next frame
    double times[qc_maxPeerRounds * qc_maxPeerFrames];
} Runner;

typedef struct Race
{
    const qcPeersOptions* options;
    const qcAnimation* animation;
    qcDevice* device;
    uint32_t threads;
    qcPeerBody* bodies;
    qcPeerPose* poses;
    double** world; ///< rigid bodies: the positions that peers are given
    Runner* runners;
    uint32_t runnerCount;
    qcPeerTask task;
} Race;

//  ---- where the bodies are ------------------------------------------------------------------------

/// World positions as the library computes them, to the last bit. Timed as a peer's work: peers have no transforms.
static void Carry(const qcMesh* body, const qcTransform* t, uint32_t threads, double* out)
{
    const float* in = body->positions;
    (void)threads; // where there is no OpenMP
#pragma omp parallel for num_threads(threads) if (threads > 1)
    for (size_t vertex = 0; vertex < body->vertexCount; ++vertex)
    {
        const double p[3] = {in[3 * vertex], in[3 * vertex + 1], in[3 * vertex + 2]};
        for (size_t axis = 0; axis < 3; ++axis)
        {
            const double* row = t->linear + 3 * axis;
            out[3 * vertex + axis] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + t->translation[axis];
        }
    }
}

static void Pose(Race* race, uint32_t frame)
{
    const qcAnimation* animation = race->animation;
    for (uint32_t i = 0; i < animation->bodyCount; ++i)
    {
        size_t k = (size_t)frame * animation->bodyCount + i;
        if (animation->kind == qc_animatedRigid)
        {
            Carry(&animation->bodies[i], &animation->transforms[k], race->threads, race->world[i]);
            race->poses[i] = (qcPeerPose){NULL, race->world[i]};
        }
        else
            race->poses[i] = (qcPeerPose){animation->positions[k], NULL};
    }
}

static bool Prepare(Race* race, uint32_t runnerCount, qcMessage* message)
{
    const qcAnimation* animation = race->animation;
    race->bodies = calloc(animation->bodyCount, sizeof *race->bodies);
    race->poses = calloc(animation->bodyCount, sizeof *race->poses);
    race->world = calloc(animation->bodyCount, sizeof *race->world);
    race->runners = calloc(runnerCount, sizeof *race->runners);
    bool made = race->bodies != NULL && race->poses != NULL && race->world != NULL && race->runners != NULL;
    for (uint32_t i = 0; made && i < animation->bodyCount; ++i)
    {
        const qcMesh* mesh = &animation->bodies[i];
        race->bodies[i] = (qcPeerBody){mesh->indices, mesh->vertexCount, mesh->triangleCount};
        if (animation->kind != qc_animatedRigid)
            continue;
        race->world[i] = malloc((size_t)mesh->vertexCount * 3 * sizeof(double));
        made = race->world[i] != NULL;
    }
    race->task = (qcPeerTask){race->bodies, animation->bodyCount, animation->kind == qc_animatedSelf, race->threads};
    return made || qcMessage_Fail(message, "out of memory");
}

//  ---- a step --------------------------------------------------------------------------------------

static void Skip(Runner* runner, const char* why)
{
    snprintf(runner->row->skipped, sizeof runner->row->skipped, "%s", why);
}

static bool IsOurs(const Runner* runner)
{
    return runner->row->entrant.library == NULL;
}

static void Open(Race* race, Runner* runner)
{
    const qcPeerEntrant* entrant = &runner->row->entrant;
    double start = qcStopwatch_NowMs();
    if (!IsOurs(runner))
    {
        Pose(race, 0);
        runner->state = entrant->library->open(&race->task, entrant->method, race->poses);
        if (runner->state == NULL)
            Skip(runner, "the library refused the bodies, or out of memory");
    }
    else if (!qcAnimatedScene_Open(race->animation, race->device, &runner->ours))
        Skip(runner, qcLastMessage());
    runner->row->openMs = qcStopwatch_NowMs() - start;
}

static void Close(Runner* runner)
{
    if (runner->state != NULL)
        runner->row->entrant.library->close(runner->state);
    qcAnimatedScene_Close(&runner->ours);
}

/// Records the pairs of the last step under their frame.
static void Look(Runner* runner, uint32_t frame)
{
    qcPeerSeen* seen = &runner->row->seen[frame];
    if (seen->ran)
        return;
    seen->ran = true;
    if (IsOurs(runner))
    {
        const qcResult* result = runner->ours.result;
        seen->pairs = result->pairCount;
        for (size_t i = 0; i < result->pairCount; ++i)
        {
            const qcPair* p = &result->pairs[i];
            seen->sum += qcHashOfPair(p->bodyA, p->triangleA, p->bodyB, p->triangleB);
        }
        return;
    }
    seen->pairs = runner->answer.count;
    for (size_t i = 0; i < runner->answer.count; ++i)
    {
        const qcPeerPair* p = &runner->answer.pairs[i];
        seen->sum += qcHashOfPair(p->bodyA, p->triangleA, p->bodyB, p->triangleB);
    }
}

/// Runs the next frame and returns its time. A method that fails is skipped.
static double Step(Race* race, Runner* runner)
{
    const qcPeerEntrant* entrant = &runner->row->entrant;
    uint32_t frame = runner->next++ % race->animation->frameCount;
    double start = qcStopwatch_NowMs();
    bool ran;
    if (IsOurs(runner))
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.method = (qcMethod)entrant->method;
        def.threads = race->threads;
        ran = qcAnimatedScene_Step(&runner->ours, race->animation, frame, &def);
    }
    else
    {
        Pose(race, frame);
        ran = entrant->library->step(runner->state, race->poses, &runner->answer);
    }
    double ms = qcStopwatch_NowMs() - start;
    if (!ran)
        Skip(runner, IsOurs(runner) ? qcLastMessage() : "the library failed, or out of memory");
    else if (IsOurs(runner) && runner->ours.result->profile.fallback != NULL)
        Skip(runner, runner->ours.result->profile.fallback);
    else
        Look(runner, frame);
    return ms;
}

//  ---- turns ---------------------------------------------------------------------------------------

/// Runs a turn that is not timed: structures are built, and buffers grow.
static void WarmUp(Race* race, Runner* runner)
{
    Open(race, runner);
    if (runner->row->skipped[0] == 0)
        runner->row->firstMs = Step(race, runner);
    if (runner->row->skipped[0] == 0)
        runner->row->secondMs = Step(race, runner);
    bool settles = IsOurs(runner) && runner->row->entrant.method == qc_methodSweep;
    for (uint32_t i = 0; settles && i < qc_settlingSteps && runner->row->skipped[0] == 0; ++i)
        (void)Step(race, runner);
}

static void TakeTurn(Race* race, Runner* runner)
{
    double spent = 0.0;
    qcStopwatch_Rest();
    for (uint32_t i = 0; i < race->animation->frameCount && runner->row->skipped[0] == 0; ++i)
    {
        if (i > qc_minTimed && spent > s_enoughMs)
            break;
        double ms = Step(race, runner);
        spent += ms;
        if (i > 0)
            runner->times[runner->row->steps++] = ms;
    }
}

/// Compares a method with our sweep in the frames in which both ran.
static void Compare(const qcPeerRow* ours, qcPeerRow* row)
{
    row->pairs = row->seen[0].pairs;
    row->agrees = true;
    for (int i = 0; i < qc_maxPeerFrames; ++i)
    {
        const qcPeerSeen *a = &ours->seen[i], *b = &row->seen[i];
        if (a->ran && b->ran && (a->pairs != b->pairs || a->sum != b->sum))
            row->agrees = false;
    }
}

static void Finish(Race* race)
{
    for (uint32_t i = 0; i < race->runnerCount; ++i)
    {
        Runner* runner = &race->runners[i];
        qcPeerRow* row = runner->row;
        row->ms = qcStopwatch_Median(runner->times, row->steps);
        row->minMs = runner->times[0];
        Compare(race->runners[0].row, row);
    }
}

static void Run(Race* race, const qcPeerEntrant* entrants, uint32_t entrantCount, qcPeersTable* table)
{
    for (uint32_t i = 0; i < entrantCount; ++i)
    {
        if (race->threads > 1 && !entrants[i].threaded)
            continue;
        Runner* runner = &race->runners[race->runnerCount++];
        runner->row = &table->rows[table->rowCount++];
        *runner->row = (qcPeerRow){.entrant = entrants[i], .threads = race->threads};
        WarmUp(race, runner);
    }
    for (uint32_t round = 0; round < race->options->rounds; ++round)
    {
        for (uint32_t i = 0; i < race->runnerCount; ++i)
        {
            TakeTurn(race, &race->runners[i]);
            qcProgress_Update(round * race->runnerCount + i + 1);
        }
    }
    Finish(race);
}

bool qcPeers_Measure(const qcPeersOptions* options, const qcAnimation* animation, const qcPeerEntrant* entrants,
                     uint32_t entrantCount, qcDevice* device, uint32_t threads, qcPeersTable* table, qcMessage* message)
{
    Race race = {.options = options, .animation = animation, .device = device, .threads = threads};
    char label[64];
    snprintf(label, sizeof label, "%s, threads: %u", qcPeerScene_Name(animation->index), threads);
    bool prepared = Prepare(&race, entrantCount, message);
    if (prepared)
    {
        qcProgress_Begin((uint64_t)options->rounds * entrantCount, label);
        Run(&race, entrants, entrantCount, table);
        qcProgress_End();
    }
    const char* broken = race.runnerCount != 0 ? race.runners[0].row->skipped : "";
    for (uint32_t i = 0; i < race.runnerCount; ++i)
        Close(&race.runners[i]);
    for (uint32_t i = 0; race.world != NULL && i < animation->bodyCount; ++i)
        free(race.world[i]);
    free(race.bodies);
    free(race.poses);
    free(race.world);
    free(race.runners);
    if (prepared && broken[0] != 0)
        return qcMessage_Fail(message, "%s: %s", qcPeerScene_Name(animation->index), broken);
    return prepared;
}
