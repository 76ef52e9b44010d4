// Embree beside the library's methods: it gets all bodies as one soup of triangles in world space, whose positions are
// computed in its time. Where bodies come or go it starts anew, in that frame's time. It is left out where most bodies
// have no self-collision: in one soup it would find the pairs within them, too.
#include "bench/paper/paper.h"

#include "bench/peers/modules.h"
#include "common/progress.h"
#include "common/stopwatch.h"

#include <stdlib.h>
#include <string.h>

typedef struct Embree
{
    const qcPeerLibrary* library;
    void* state;
    uint32_t changes; ///< of the soup when it was opened
    qcPeerBody body;
    qcPeerTask task;
    qcPeerPair* sorted; ///< the last answer, the lower triangle first
    size_t capacity;
} Embree;

static void Close(Embree* embree)
{
    if (embree->state != NULL)
        embree->library->close(embree->state);
    embree->state = NULL;
}

/// New positions in, pairs out.
static bool Step(Embree* embree, qcPaperSoup* soup, qcPeerAnswer* answer)
{
    if (embree->state == NULL || embree->changes != soup->changes)
    {
        Close(embree);
        if (!qcPaperSoup_Collect(soup))
            return false;
        embree->changes = soup->changes;
        embree->body = (qcPeerBody){soup->indices, soup->vertexCount, soup->triangleCount};
    }
    qcPaperSoup_Place(soup);
    const qcPeerPose pose = {NULL, soup->positions};
    if (embree->state == NULL)
        embree->state = embree->library->open(&embree->task, 0, &pose);
    return embree->state != NULL && embree->library->step(embree->state, &pose, answer);
}

static int ComparePairs(const void* x, const void* y)
{
    const qcPeerPair *a = x, *b = y;
    if (a->triangleA != b->triangleA)
        return a->triangleA < b->triangleA ? -1 : 1;
    return a->triangleB < b->triangleB ? -1 : a->triangleB > b->triangleB;
}

static bool Sort(Embree* embree, const qcPeerAnswer* answer)
{
    if (answer->count > embree->capacity)
    {
        qcPeerPair* grown = realloc(embree->sorted, answer->count * sizeof *grown);
        if (grown == NULL)
            return false;
        embree->sorted = grown;
        embree->capacity = answer->count;
    }
    for (size_t i = 0; i < answer->count; ++i)
    {
        qcPeerPair pair = answer->pairs[i];
        if (pair.triangleA > pair.triangleB)
            pair = (qcPeerPair){0, pair.triangleB, 0, pair.triangleA};
        embree->sorted[i] = pair;
    }
    if (answer->count != 0)
        qsort(embree->sorted, answer->count, sizeof *embree->sorted, ComparePairs);
    return true;
}

/// Counts the pairs that Embree has and lacks. It may have more than the library, which leaves out pairs of bodies at
/// rest, of bodies without self-collision and of groups that don't meet.
static void Compare(const Embree* embree, size_t count, const qcPaperSoup* soup, const qcResult* exact,
                    qcPaperCell* cell)
{
    cell->found = cell->missed = 0;
    for (size_t i = 0; i < exact->pairCount; ++i)
    {
        const qcPair* pair = &exact->pairs[i];
        uint32_t a = soup->firstTriangles[pair->bodyA] + pair->triangleA;
        uint32_t b = soup->firstTriangles[pair->bodyB] + pair->triangleB;
        const qcPeerPair key = {0, a < b ? a : b, 0, a < b ? b : a};
        bool found = count != 0 && bsearch(&key, embree->sorted, count, sizeof key, ComparePairs) != NULL;
        cell->found += found;
        cell->missed += !found;
    }
}

static bool RunFrame(Embree* embree, qcPaperReplay* replay, qcPaperTable* table, qcMessage* message)
{
    qcPaperCell* cell = &table->cells[qc_paperEmbree][replay->frame];
    qcPeerAnswer answer;
    double start = qcStopwatch_NowMs(), ms;
    if (!Step(embree, replay->soup, &answer))
        return qcMessage_Fail(message, "%s, frame %u: Embree failed, or out of memory", replay->path, replay->frame);
    if (cell->timeCount < qc_maxPaperRounds)
        cell->times[cell->timeCount++] = qcStopwatch_NowMs() - start;
    if (cell->ran)
        return true;
    cell->ran = true;
    qcDetectDef def = qcPaperReplay_PlainDef(replay);
    def.method = qc_methodSweep;
    const qcResult* exact;
    if (!Sort(embree, &answer))
        return qcMessage_Fail(message, "out of memory");
    if (!qcPaperReplay_Detect(replay, &def, &exact, &ms, message))
        return false;
    Compare(embree, answer.count, replay->soup, exact, cell);
    if (cell->missed != 0)
        return qcMessage_Fail(message, "%s, frame %u: Embree lacks %u pairs of sweep", replay->path, replay->frame,
                              (unsigned)cell->missed);
    return true;
}

bool qcPaper_MeasureEmbree(const qcPaperOptions* options, const char* path, uint32_t round, qcPaperTable* table,
                           qcMessage* message)
{
    Embree embree = {.library = NULL};
    if (!qcPeerModule_Load(qc_peerEmbree, &embree.library, message))
        return false;
    if (embree.library == NULL)
        return true;
    snprintf(table->embree, sizeof table->embree, "%s", embree.library->name);
    if (!table->info.isOneSoup)
        return true;
    uint32_t threads = options->threads != 0 ? options->threads : qcGetWorkerCount();
    embree.task = (qcPeerTask){&embree.body, 1, true, threads};
    qcPaperSoup soup = {0};
    qcPaperReplay replay;
    bool more = true, done = qcPaperReplay_Open(path, NULL, &replay, message);
    replay.soup = &soup;
    replay.frameLimit = table->info.frameCount;
    qcProgress_Begin(table->info.frameCount, round == 0 ? "Embree, and its pairs compared" : "Embree");
    while (done && more)
    {
        done = qcPaperReplay_Next(&replay, &more, message);
        if (done && more)
            done = RunFrame(&embree, &replay, table, message);
        qcProgress_Update(replay.nextFrame);
    }
    qcProgress_End();
    Close(&embree);
    free(embree.sorted);
    qcPaperSoup_Free(&soup);
    qcPaperReplay_Close(&replay);
    return done;
}
