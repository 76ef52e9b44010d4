// The time of the motion query beside the plain one, on the same frames.
#include "bench/through/motion_query.h"

#include "bench/scenes/animated_scene.h"
#include "bench/scenes/shapes.h"
#include "common/interrupt.h"
#include "common/stopwatch.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum
{
    qc_frameCount = 6,
    qc_minRounds = 9,
    qc_maxRounds = 60
};

// For one size and number of threads.
static const double s_enoughMs = 1500.0;

// Shallow: no triangles penetrate, as in a step whose motion is certified.
static const double s_wrinkles = 0.3;

static const uint32_t s_sizes[] = {20000, 250000, 1000000};

typedef struct Query
{
    qcAnimatedScene scene;
    qcDetectDef def;
    double times[qc_maxRounds]; ///< the first includes the building of hierarchies
} Query;

/// A frame of one of the queries; the time of copying positions is left out.
static bool Step(Query* query, const qcAnimation* animation, uint32_t round)
{
    double start = qcStopwatch_NowMs();
    if (query->def.motion && qcScene_MarkStart(query->scene.scene) != qc_statusOk)
        return false;
    if (!qcAnimatedScene_Step(&query->scene, animation, round % animation->frameCount, &query->def))
        return false;
    query->times[round] = qcStopwatch_NowMs() - start - query->scene.moveMs;
    return true;
}

static bool MakeCloth(uint32_t triangleCount, qcAnimation* animation)
{
    *animation = (qcAnimation){.kind = qc_animatedSelf, .bodyCount = 1, .frameCount = qc_frameCount};
    animation->bodies = calloc(1, sizeof *animation->bodies);
    if (animation->bodies == NULL ||
        !qcBenchShapes_MakeCloth((uint32_t)lround(sqrt(0.5 * triangleCount)), s_wrinkles, &animation->bodies[0]))
        return false;
    animation->triangleCount = animation->bodies[0].triangleCount;
    return qcAnimation_MakeFrames(animation);
}

/// The queries take turns, and change their order each round.
static bool Measure(const qcAnimation* animation, uint32_t threads)
{
    Query queries[2] = {{.def = qcDefaultDetectDef()}, {.def = qcDefaultDetectDef()}};
    bool ok = true;
    for (int i = 0; i < 2 && ok; ++i)
    {
        queries[i].def.method = qc_methodSweep;
        queries[i].def.threads = threads;
        queries[i].def.motion = i == 1;
        ok = qcAnimatedScene_Open(animation, NULL, &queries[i].scene);
    }
    uint32_t rounds = 0;
    double start = 0.0;
    for (; ok && rounds < qc_maxRounds; ++rounds)
    {
        if (rounds == 1)
            start = qcStopwatch_NowMs();
        if (rounds > qc_minRounds && qcStopwatch_NowMs() - start > s_enoughMs)
            break;
        ok = Step(&queries[rounds % 2], animation, rounds) && Step(&queries[1 - rounds % 2], animation, rounds);
    }
    if (ok)
    {
        size_t pairs[2] = {queries[0].scene.result->pairCount, queries[1].scene.result->pairCount};
        double plain = qcStopwatch_Median(queries[0].times + 1, rounds - 1);
        double motion = qcStopwatch_Median(queries[1].times + 1, rounds - 1);
        printf("%9u %8s %10.3f %10.3f %7.2f %8zu %8zu\n", animation->triangleCount, threads == 1 ? "1" : "all", plain,
               motion, motion / plain, pairs[0], pairs[1]);
        fflush(stdout);
    }
    qcAnimatedScene_Close(&queries[0].scene);
    qcAnimatedScene_Close(&queries[1].scene);
    return ok;
}

bool qcMeasureMotionQuery(uint32_t maxTriangles, qcMessage* message)
{
    printf("\nThe motion query beside the plain one (margin 0), sweep, on the same frames of folded cloths; medians of "
           "turns\n%9s %8s %10s %10s %7s %8s %8s\n",
           "triangles", "threads", "plain, ms", "motion, ms", "ratio", "pairs", "unproven");
    bool ok = true;
    for (size_t i = 0; ok && i < sizeof s_sizes / sizeof s_sizes[0] && s_sizes[i] <= maxTriangles; ++i)
    {
        qcAnimation animation;
        ok = MakeCloth(s_sizes[i], &animation) || qcMessage_Fail(message, "out of memory");
        for (uint32_t threads = 2; ok && threads-- > 0 && qcInterrupt_Signal() == 0;)
            ok = Measure(&animation, threads) || qcMessage_Fail(message, "%s", qcLastMessage());
        qcAnimation_Free(&animation);
    }
    return ok;
}
