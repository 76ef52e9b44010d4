// Many bodies in one scene: the manifolds of two of them depend on no other body, nor on the number of threads. The
// oracle is the scene of these two alone, to the last bit.
#include "manifold/manifold_scenes.h"
#include "support/suite.h"

enum
{
    qc_bodyCount = 9,
    // More than one thread shares the pairs of two bodies from 2 048 on.
    qc_sharedPairs = 2048
};

static const double s_margin = 0.01;

typedef struct World
{
    qcSoup soups[qc_bodyCount];
    bool deforming[qc_bodyCount];
} World;

/// Floors of different tiles, as rough as they are far from each other, balls that stand in them, and a cloth in folds.
static World MakeWorld(void)
{
    static const uint32_t sides[] = {2, 3, 5, 9, 30, 34};
    World world = {.deforming = {false, false, true}};
    for (uint32_t i = 0; i < 6; i++)
        world.soups[i] = qcMakeRoughFloor(i + 1, sides[i], 0.004 * i, 0.02);
    for (uint32_t i = 6; i < 8; i++)
    {
        world.soups[i] = qcSoup_MakeSphere(i - 4, 0.2);
        qcSoup_Translate(&world.soups[i], 0.3 * (i - 5), 0.4, 0.2);
    }
    world.soups[8] = qcSoup_MakeFoldedCloth(3, 24, 0.004, 0.001);
    world.deforming[8] = true;
    return world;
}

static void FreeWorld(World* world)
{
    for (int i = 0; i < qc_bodyCount; i++)
        qcSoup_Free(&world->soups[i]);
}

/// Detects the bodies whose bits are set; deforming ones collide with themselves too. The caller destroys the scene.
static const qcResult* Find(const World* world, unsigned bodies, bool proximities, uint32_t threads, qcScene** scene)
{
    *scene = qcMakeScene(NULL);
    for (int i = 0; i < qc_bodyCount; i++)
    {
        if ((bodies >> i & 1u) == 0)
            continue;
        qcBodyDef def = qcBodyDefOf(&world->soups[i]);
        qcBodyId id;
        def.deforming = def.selfCollision = world->deforming[i];
        CHECK_OK(qcScene_AddBody(*scene, &def, &id));
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.margin = s_margin;
    def.touching = def.manifolds = true;
    def.proximities = proximities;
    def.threads = threads;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(*scene, &def, &result));
    return result;
}

/// The first manifold of two bodies, or one past those of all earlier pairs of bodies.
static size_t FirstOf(const qcResult* result, uint32_t a, uint32_t b)
{
    size_t i = 0;
    while (i < result->manifoldCount &&
           (result->manifolds[i].bodyA < a || (result->manifolds[i].bodyA == a && result->manifolds[i].bodyB < b)))
        i++;
    return i;
}

/// Checks that bodies a and b of one scene have the manifolds of c and d in another one. Returns the number of their
/// points.
static size_t CheckSame(const qcResult* m, uint32_t a, uint32_t b, const qcResult* n, uint32_t c, uint32_t d)
{
    size_t i = FirstOf(m, a, b), end = FirstOf(m, a, b + 1), k = FirstOf(n, c, d), points = 0;
    ck_assert_uint_eq(end - i, FirstOf(n, c, d + 1) - k);
    for (; i < end; i++, k++)
    {
        const qcManifold *p = &m->manifolds[i], *q = &n->manifolds[k];
        ck_assert_uint_eq(p->pointCount, q->pointCount);
        ck_assert_mem_eq(m->manifoldPoints + p->firstPoint, n->manifoldPoints + q->firstPoint,
                         p->pointCount * sizeof(qcManifoldPoint));
        points += p->pointCount;
    }
    return points;
}

static void CheckPairsOfBodies(bool proximities)
{
    World world = MakeWorld();
    qcScene *all, *two;
    const qcResult* m = Find(&world, (1u << qc_bodyCount) - 1, proximities, 2, &all);
    size_t points = 0, meetings = 0;
    for (uint32_t a = 0; a < qc_bodyCount; a++)
        for (uint32_t b = a + 1; b < qc_bodyCount; b++)
        {
            const qcResult* n = Find(&world, 1u << a | 1u << b, proximities, 1, &two);
            size_t found = CheckSame(m, a, b, n, 0, 1);
            points += found;
            meetings += found != 0;
            // Each body with itself too, once.
            if (b == a + 1)
                points += CheckSame(m, a, a, n, 0, 0);
            if (b == a + 1 && b == qc_bodyCount - 1)
                points += CheckSame(m, b, b, n, 1, 1);
            qcScene_Destroy(two);
        }
    // No other point is there, and there are enough for a mistake to show.
    ck_assert_uint_eq(points, m->manifoldPointCount);
    ck_assert_uint_ge(meetings, 20);
    ck_assert_uint_lt(FirstOf(m, 8, 8), FirstOf(m, 8, 9));
    qcScene_Destroy(all);
    FreeWorld(&world);
}

START_TEST(manifolds_of_two_bodies_depend_on_no_other_body)
{
    CheckPairsOfBodies(false);
}
END_TEST

START_TEST(with_proximities_manifolds_of_two_bodies_depend_on_no_other_body)
{
    CheckPairsOfBodies(true);
}
END_TEST

/// The maximum and the minimum number of pairs of two bodies.
static void CountPairs(const qcResult* result, size_t* most, size_t* fewest)
{
    size_t counts[qc_bodyCount][qc_bodyCount] = {{0}};
    for (size_t i = 0; i < result->pairCount; i++)
        counts[result->pairs[i].bodyA][result->pairs[i].bodyB]++;
    *most = 0;
    *fewest = SIZE_MAX;
    for (int i = 0; i < qc_bodyCount * qc_bodyCount; i++)
    {
        size_t count = counts[i / qc_bodyCount][i % qc_bodyCount];
        *most = count > *most ? count : *most;
        *fewest = count != 0 && count < *fewest ? count : *fewest;
    }
}

START_TEST(manifolds_of_many_bodies_do_not_depend_on_the_number_of_threads)
{
    World world = MakeWorld();
    qcScene *one, *some;
    size_t most, fewest;
    const qcResult* m = Find(&world, (1u << qc_bodyCount) - 1, false, 1, &one);
    // Some two bodies have enough pairs to be shared by all threads, even where two threads run.
    CountPairs(m, &most, &fewest);
    ck_assert_uint_ge(most, qc_sharedPairs);
    ck_assert_uint_ge(most, m->pairCount / 4);
    ck_assert_uint_lt(fewest, 200);
    for (uint32_t threads = 2; threads <= 8; threads *= 2)
    {
        const qcResult* n = Find(&world, (1u << qc_bodyCount) - 1, false, threads, &some);
        ck_assert_uint_eq(m->manifoldCount, n->manifoldCount);
        ck_assert_uint_eq(m->manifoldPointCount, n->manifoldPointCount);
        ck_assert_mem_eq(m->manifolds, n->manifolds, m->manifoldCount * sizeof(qcManifold));
        ck_assert_mem_eq(m->manifoldPoints, n->manifoldPoints, m->manifoldPointCount * sizeof(qcManifoldPoint));
        qcScene_Destroy(some);
    }
    qcScene_Destroy(one);
    FreeWorld(&world);
}
END_TEST

QC_RUN_TESTS("manifold_bodies", manifolds_of_two_bodies_depend_on_no_other_body,
             with_proximities_manifolds_of_two_bodies_depend_on_no_other_body,
             manifolds_of_many_bodies_do_not_depend_on_the_number_of_threads)
