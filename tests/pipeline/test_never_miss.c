// Pairs of triangles on the border between intersecting and disjoint, or exactly the margin apart, thousands to a
// scene: `layers` on each device, `sweep` and `auto` report the pairs of brute force and no other. QC_TEST_PAIRS: the
// number of pairs to build (raise CK_TIMEOUT_MULTIPLIER with it).
#include "support/devices.h"
#include "support/long_form.h"
#include "support/oracle.h"
#include "support/pairs.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>
#include <stdio.h>

enum
{
    qc_pairsInScene = 1200,
    qc_pairsInGroup = 24,  ///< where there are many bodies
    qc_minPairs = 36000,   ///< by test
    qc_fewPairs = 12000,   ///< in the short form, where devices refine: in software that takes six times as long
    qc_oracleStride = 400, ///< one pair in 400 goes through the oracle
    qc_maxBodies = 2 * qc_pairsInScene / qc_pairsInGroup
};

//  ---- pairs -----------------------------------------------------------------------------------------------------

/// Rules by which the pairs of a scene are made and arranged.
typedef struct Recipe
{
    double unit;      ///< the largest triangles are about this large; a power of two
    int shrink;       ///< max. powers of two by which it is smaller
    double margin;    ///< 0, or with so few bits that the pair is exact
    bool isHeap;      ///< pairs among each other, or each by itself
    double offset[3]; ///< of the scene
} Recipe;

static void Multiply(qcTrianglePair* pair, double factor)
{
    for (int i = 0; i < 9; i++)
    {
        pair->a[i / 3][i % 3] *= factor;
        pair->b[i / 3][i % 3] *= factor;
    }
}

static void Move(double corners[3][3], const double by[3], double sign)
{
    for (int i = 0; i < 9; i++)
        corners[i / 3][i % 3] += sign * by[i % 3];
}

static void MoveToOrigin(qcTrianglePair* pair)
{
    const double corner[3] = {pair->a[0][0], pair->a[0][1], pair->a[0][2]};
    Move(pair->a, corner, -1);
    Move(pair->b, corner, -1);
}

/// Scales a pair by a power of two, so that the largest coordinate is within (size / 2, size].
static void FitSize(qcTrianglePair* pair, double size)
{
    double largest = qcTrianglePair_GetLargest(pair);
    if (largest > 0)
        for (int i = 0; i < 9; i++)
        {
            int exponent = ilogb(size) - 1 - ilogb(largest);
            pair->a[i / 3][i % 3] = ldexp(pair->a[i / 3][i % 3], exponent);
            pair->b[i / 3][i % 3] = ldexp(pair->b[i / 3][i % 3], exponent);
        }
}

static void MakeMeeting(qcRandom* random, const Recipe* recipe, qcTrianglePair* pair)
{
    qcTrianglePair_Make(random, (qcPairKind)qcRandom_Below(random, qc_pairKindCount), pair);
    MoveToOrigin(pair);
    FitSize(pair, ldexp(recipe->unit, -(int)qcRandom_Integer(random, 0, recipe->shrink)));
}

static double Mantissa(double x)
{
    int exponent;
    return frexp(x, &exponent);
}

/// Exactly the margin apart.
static void MakeApart(qcRandom* random, const Recipe* recipe, qcTrianglePair* pair)
{
    double distance = 0;
    while (Mantissa(distance) != Mantissa(recipe->margin))
        qcTrianglePair_MakeApart(random, 1 + (int)qcRandom_Below(random, 3), 1 + (int)qcRandom_Below(random, 3), pair,
                                 &distance);
    MoveToOrigin(pair);
    for (int i = 0; i < 9; i++)
    {
        int exponent = ilogb(recipe->margin) - ilogb(distance);
        pair->a[i / 3][i % 3] = ldexp(pair->a[i / 3][i % 3], exponent);
        pair->b[i / 3][i % 3] = ldexp(pair->b[i / 3][i % 3], exponent);
    }
}

/// Triangles of any shape, the margin apart but for some roundings.
static void MakeNearlyApart(qcRandom* random, const Recipe* recipe, qcTrianglePair* pair)
{
    double largest;
    do
    {
        qcTrianglePair_Make(random, (qcPairKind)qcRandom_Below(random, qc_pairKindCount), pair);
        MoveToOrigin(pair);
        FitSize(pair, 1);
        qcProximity proximity;
        double by[3];
        for (int axis = 0; axis < 3; axis++)
            by[axis] = qcRandom_Uniform(random, -2, 2);
        Move(pair->b, by, 1);
        qcTrianglesWithin(&pair->a[0][0], &pair->b[0][0], 16, &proximity);
        largest =
            proximity.distance > 0 ? qcTrianglePair_GetLargest(pair) * recipe->margin / proximity.distance : INFINITY;
        if (largest <= recipe->unit)
            Multiply(pair, recipe->margin / proximity.distance);
    } while (!(largest <= recipe->unit));
}

/// Places a pair in the scene: in a cell of its own, or anywhere in a heap, by steps that preserve the pair exactly if
/// bits suffice.
static void Place(qcRandom* random, const Recipe* recipe, uint32_t number, qcTrianglePair* pair)
{
    // 11^3 cells hold qc_pairsInScene; a cell holds a pair and twice the margin. In the heap each overlaps a few.
    uint32_t cell[3] = {number % 11, number / 11 % 11, number / 121};
    double by[3];
    for (int axis = 0; axis < 3; axis++)
        by[axis] =
            recipe->offset[axis] + (recipe->isHeap ? recipe->unit / 16 * qcRandom_Integer(random, 0, 16 * 8)
                                                   : 4 * recipe->unit * cell[axis] + 4 * recipe->margin * cell[axis]);
    Move(pair->a, by, 1);
    Move(pair->b, by, 1);
    if (qcRandom_Below(random, 2) == 0)
        qcTrianglePair_MoveByUlps(random, pair);
}

//  ---- scenes ----------------------------------------------------------------------------------------------------

typedef enum Layout
{
    layout_one,  ///< one body, with itself
    layout_two,  ///< a body for each side
    layout_many, ///< and for each group of pairs
    layout_count
} Layout;

/// The bodies of a scene, equal for the scenes of all devices.
typedef struct Plan
{
    uint64_t seed;
    Recipe recipe;
    Layout layout;
    uint32_t bodyCount;
    qcBodyDef defs[qc_maxBodies];
    double* positions[qc_maxBodies];
    uint32_t indices[6 * qc_pairsInScene];
} Plan;

static uint32_t BodyOf(const Plan* plan, uint32_t pair, uint32_t side)
{
    return plan->layout == layout_one ? 0 : plan->layout == layout_two ? side : 2 * (pair / qc_pairsInGroup) + side;
}

static uint32_t TriangleOf(const Plan* plan, uint32_t pair, uint32_t side)
{
    return plan->layout == layout_one ? 2 * pair + side : plan->layout == layout_two ? pair : pair % qc_pairsInGroup;
}

static void SetRotation(qcRandom* random, double linear[9])
{
    double q[4], length = 0;
    for (int i = 0; i < 4; i++)
    {
        q[i] = qcRandom_Uniform(random, -1, 1);
        length += q[i] * q[i];
    }
    for (int i = 0; i < 3; i++)
    {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        linear[4 * i] = (q[3] * q[3] + q[i] * q[i] - q[j] * q[j] - q[k] * q[k]) / length;
        linear[3 * i + j] = 2 * (q[i] * q[j] - q[3] * q[k]) / length;
        linear[3 * i + k] = 2 * (q[i] * q[k] + q[3] * q[j]) / length;
    }
}

/// None; one that rounds nothing where bits suffice; a rotation; a rotation about a far point.
static void SetTransform(qcRandom* random, const Recipe* recipe, qcTransform* transform)
{
    uint32_t kind = qcRandom_Below(random, 8);
    *transform = qcIdentityTransform();
    if (kind < 2)
        return;
    if (kind < 5)
    {
        uint32_t turn = qcRandom_Below(random, 3);
        for (uint32_t i = 0; i < 9; i++)
            transform->linear[i] = (i / 3 + turn) % 3 != i % 3 ? 0 : qcRandom_Below(random, 2) == 0 ? 1 : -1;
    }
    else
        SetRotation(random, transform->linear);
    int range = kind < 7 ? 8 : 10000000;
    for (int axis = 0; axis < 3; axis++)
        transform->translation[axis] = recipe->offset[axis] + recipe->unit * qcRandom_Integer(random, -range, range);
}

/// The local corner whose transform is `world`, rounded.
static void ToLocal(const qcTransform* transform, const double world[3], double local[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        local[axis] = 0;
        for (int i = 0; i < 3; i++)
            local[axis] += transform->linear[3 * i + axis] * (world[i] - transform->translation[i]);
    }
}

/// The arithmetic of qcTransform in scene.h.
static void ToWorld(const qcTransform* transform, const double local[3], double world[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        const double* row = transform->linear + 3 * axis;
        world[axis] = row[0] * local[0] + row[1] * local[1] + row[2] * local[2] + transform->translation[axis];
    }
}

static void MakeRecipe(qcRandom* random, bool hasMargin, Recipe* recipe)
{
    static const double s_mantissas[] = {1, 1.5, 1.125};
    int exponent = (int)qcRandom_Integer(random, -20, 20);
    if (qcRandom_Below(random, 24) == 0)
        exponent = (const int[]){-900, 900, -1000}[qcRandom_Below(random, 3)];
    *recipe = (Recipe){.unit = ldexp(1, exponent), .isHeap = qcRandom_Below(random, 2) == 0};
    recipe->shrink = (const int[]){0, 4, 24, 40}[qcRandom_Below(random, 4)];
    uint32_t offset = qcRandom_Below(random, 3);
    for (int axis = 0; axis < 3 && offset != 0; axis++)
        recipe->offset[axis] = qcRandom_Integer(random, -10000000, 10000000) * (offset == 1 ? 1 : recipe->unit);
    if (hasMargin)
        recipe->margin =
            ldexp(recipe->unit * s_mantissas[qcRandom_Below(random, 3)], -(int)qcRandom_Integer(random, 6, 12));
}

static void MakeBodies(qcRandom* random, Plan* plan, const qcTrianglePair* pairs)
{
    plan->bodyCount = BodyOf(plan, qc_pairsInScene - 1, 1) + 1;
    for (uint32_t i = 0; i < 6 * qc_pairsInScene; i++)
        plan->indices[i] = i;
    uint32_t rigid = qcRandom_Below(random, 4); // bit s: those of side s
    for (uint32_t body = 0; body < plan->bodyCount; body++)
    {
        uint32_t count = 2 * qc_pairsInScene / plan->bodyCount;
        qcBodyDef* def = &plan->defs[body];
        plan->positions[body] = malloc(9 * count * sizeof(double));
        *def = qcDefaultBodyDef();
        def->positions = plan->positions[body];
        def->positionType = qc_positionF64;
        def->vertexCount = 3 * count;
        def->indices = plan->indices;
        def->triangleCount = count;
        def->deforming = (rigid >> body % 2 & 1) == 0;
        def->selfCollision = plan->layout == layout_one || qcRandom_Below(random, 2) == 0;
        if (!def->deforming)
            SetTransform(random, &plan->recipe, &def->transform);
    }
    for (uint32_t i = 0; i < 2 * qc_pairsInScene; i++)
    {
        uint32_t body = BodyOf(plan, i / 2, i % 2);
        const double(*corners)[3] = (const double(*)[3])(i % 2 == 0 ? pairs[i / 2].a : pairs[i / 2].b);
        for (int c = 0; c < 3; c++)
            ToLocal(&plan->defs[body].transform, corners[c],
                    plan->positions[body] + 9 * TriangleOf(plan, i / 2, i % 2) + 3 * c);
    }
}

static Plan* MakePlan(uint64_t seed, Layout layout, bool hasMargin)
{
    static qcTrianglePair s_pairs[qc_pairsInScene];
    qcRandom random = {seed};
    Plan* plan = calloc(1, sizeof *plan);
    plan->seed = seed;
    plan->layout = layout;
    MakeRecipe(&random, hasMargin, &plan->recipe);
    for (uint32_t i = 0; i < qc_pairsInScene; i++)
    {
        if (!hasMargin)
            MakeMeeting(&random, &plan->recipe, &s_pairs[i]);
        else if (qcRandom_Below(&random, 2) == 0)
            MakeApart(&random, &plan->recipe, &s_pairs[i]);
        else
            MakeNearlyApart(&random, &plan->recipe, &s_pairs[i]);
        Place(&random, &plan->recipe, i, &s_pairs[i]);
    }
    MakeBodies(&random, plan, s_pairs);
    return plan;
}

static void FreePlan(Plan* plan)
{
    for (uint32_t body = 0; body < plan->bodyCount; body++)
        free(plan->positions[body]);
    free(plan);
}

static qcScene* MakeScene(const Plan* plan, qcDevice* device)
{
    qcScene* scene = qcMakeScene(device);
    for (uint32_t body = 0; body < plan->bodyCount; body++)
    {
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(scene, &plan->defs[body], &id));
    }
    return scene;
}

//  ---- comparison ------------------------------------------------------------------------------------------------

/// Counts over all scenes of a test.
typedef struct Tally
{
    uint64_t built, found, verified;         ///< pairs made; reported by brute force; tested by the oracle
    uint64_t runs, fallbacks;                ///< of `layers`
    char fallback[200];                      ///< the last reason
    uint64_t hashes[3 + qc_testDeviceCount]; ///< over all lists of brute, sweep, auto, `layers` by device
} Tally;

/// Fowler, Noll, Vo: FNV-1a, over the numbers of the pairs.
static void AddToHash(uint64_t* hash, const qcPairList* list)
{
    for (size_t i = 0; i < list->count; i++)
    {
        const qcPair* p = &list->pairs[i];
        const uint32_t words[] = {p->bodyA, p->triangleA, p->bodyB, p->triangleB, (uint32_t)p->relation};
        for (int k = 0; k < 5; k++)
            *hash = (*hash ^ words[k]) * UINT64_C(0x100000001b3);
    }
}

static const qcPair* FindPair(const Plan* plan, const qcPairList* list, uint32_t pair)
{
    const qcPair wanted = {BodyOf(plan, pair, 0), TriangleOf(plan, pair, 0), BodyOf(plan, pair, 1),
                           TriangleOf(plan, pair, 1), qc_relationDisjoint};
    return list->count != 0 ? bsearch(&wanted, list->pairs, list->count, sizeof wanted, qcComparePairs) : NULL;
}

/// Brute force against rational arithmetic.
static void CheckWithOracle(const Plan* plan, uint32_t pair, const qcPair* found)
{
    double corners[2][3][3];
    const double(*a)[3] = (const double(*)[3])corners[0], (*b)[3] = (const double(*)[3])corners[1];
    for (uint32_t side = 0; side < 2; side++)
    {
        uint32_t body = BodyOf(plan, pair, side);
        for (int c = 0; c < 3; c++)
            ToWorld(&plan->defs[body].transform, plan->positions[body] + 9 * TriangleOf(plan, pair, side) + 3 * c,
                    corners[side][c]);
    }
    qcRelation relation = qcOracle_Relate(a, b);
    if (relation == qc_relationDisjoint && plan->recipe.margin > 0)
    {
        qcOracleDistance* distance = qcOracleDistance_Create(a, b);
        if (qcOracleDistance_Compare(distance, plan->recipe.margin) <= 0)
            relation = qc_relationNear;
        qcOracleDistance_Destroy(distance);
    }
    ck_assert_msg((found != NULL ? found->relation : qc_relationDisjoint) == relation,
                  "seed %llu, pair %u: brute force says %s, the oracle %s", (unsigned long long)plan->seed, pair,
                  found != NULL ? qcRelation_Name(found->relation) : "nothing", qcRelation_Name(relation));
}

static void LookAtPairs(const Plan* plan, const qcPairList* list, Tally* tally)
{
    for (uint32_t pair = 0; pair < qc_pairsInScene; pair++)
    {
        const qcPair* found = FindPair(plan, list, pair);
        tally->found += found != NULL;
        if (tally->built++ % qc_oracleStride != 0)
            continue;
        CheckWithOracle(plan, pair, found);
        tally->verified++;
    }
}

/// Detects, compares, and adds to the hash.
static void Check(const Plan* plan, qcScene* scene, const qcDetectDef* def, const qcPairList* expected,
                  const char* device, uint64_t* hash)
{
    char what[200];
    snprintf(what, sizeof what, "seed %llu, %s on %s, %u columns, axis %d, margin %g", (unsigned long long)plan->seed,
             qcMethod_Name(def->method), device, def->layerColumns, def->layerDepthAxis, def->margin);
    qcPairList found = qcDetectPairs(scene, def);
    qcCheckSamePairs(expected, &found, what);
    AddToHash(hash, &found);
    free(found.pairs);
}

static void CheckLayers(const Plan* plan, qcScene* scene, qcDetectDef* def, const qcPairList* expected,
                        const char* device, Tally* tally, uint64_t* hash)
{
    def->method = qc_methodLayers;
    Check(plan, scene, def, expected, device, hash);
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, def, &result));
    ck_assert(result->profile.reused);
    tally->runs++;
    if (result->profile.fallback != NULL)
    {
        tally->fallbacks++;
        snprintf(tally->fallback, sizeof tally->fallback, "%s", result->profile.fallback);
    }
}

static void RunScene(const Plan* plan, qcDevice* const devices[qc_testDeviceCount], Tally* tally)
{
    qcRandom random = {~plan->seed};
    qcDetectDef def = qcDefaultDetectDef();
    def.margin = plan->recipe.margin;
    def.touching = plan->recipe.margin > 0 || qcRandom_Below(&random, 8) != 0;
    def.method = qc_methodBrute;
    qcScene* plain = MakeScene(plan, NULL);
    qcPairList expected = qcDetectPairs(plain, &def);
    AddToHash(&tally->hashes[0], &expected);
    if (def.touching)
        LookAtPairs(plan, &expected, tally);
    def.threads = (const uint32_t[]){1, 2, 8}[qcRandom_Below(&random, 3)];
    def.method = qc_methodSweep;
    Check(plan, plain, &def, &expected, "none", &tally->hashes[1]);
    // Many bodies that lie across each other each cover most of the image.
    def.layerColumns =
        (const uint32_t[]){0, 0, 1, 4, 16, 100}[qcRandom_Below(&random, plan->layout == layout_many ? 5 : 6)];
    def.layerDepthAxis = "\0xyz"[qcRandom_Below(&random, 4)];
    qcDevice* first = NULL;
    for (int d = 0; d < qc_testDeviceCount; d++)
    {
        if (devices[d] == NULL)
            continue;
        first = first == NULL ? devices[d] : first;
        qcScene* scene = MakeScene(plan, devices[d]);
        CheckLayers(plan, scene, &def, &expected, qc_testDeviceNames[qcGetTestName(d)], tally, &tally->hashes[3 + d]);
        qcScene_Destroy(scene);
    }
    def.method = qc_methodAuto;
    qcScene* scene = MakeScene(plan, first);
    Check(plan, scene, &def, &expected, "auto", &tally->hashes[2]);
    qcScene_Destroy(scene);
    qcScene_Destroy(plain);
    free(expected.pairs);
}

static int GetMinPairs(void)
{
    return qcDevicesRefine() && !qcIsLongForm() ? qc_fewPairs : qc_minPairs;
}

static void RunScenes(const char* name, uint64_t firstSeed, Layout layout, bool hasMargin)
{
    qcDevice* devices[qc_testDeviceCount];
    qcOpenTestDevices(devices);
    Tally tally = {0};
    uint64_t count = (uint64_t)qcGetTestPairCount(6 * GetMinPairs()) / 6;
    for (uint64_t seed = firstSeed; tally.built < count; seed++)
    {
        Plan* plan = MakePlan(seed, layout, hasMargin);
        RunScene(plan, devices, &tally);
        FreePlan(plan);
    }
    printf("%s: %llu pairs, %llu of them reported, %llu verified by the oracle; %llu runs of layers, %llu fell back; "
           "hash %016llx\n",
           name, (unsigned long long)tally.built, (unsigned long long)tally.found, (unsigned long long)tally.verified,
           (unsigned long long)tally.runs, (unsigned long long)tally.fallbacks, (unsigned long long)tally.hashes[0]);
    for (int i = 1; i < 3 + qc_testDeviceCount; i++)
        ck_assert(tally.hashes[i] == tally.hashes[0] || (i >= 3 && devices[i - 3] == NULL));
    // Built for the border: neither all nor none are reported.
    ck_assert_uint_gt(tally.found, tally.built / 5);
    ck_assert_uint_lt(tally.found, tally.built - tally.built / 20);
    ck_assert_msg(10 * tally.fallbacks <= tally.runs, "%s", tally.fallback);
    qcCloseTestDevices(devices);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

START_TEST(barely_touching_pairs_in_one_body_are_never_missed)
{
    RunScenes("one body", UINT64_C(1000000), layout_one, false);
}
END_TEST

START_TEST(barely_touching_pairs_of_two_bodies_are_never_missed)
{
    RunScenes("two bodies", UINT64_C(2000000), layout_two, false);
}
END_TEST

START_TEST(barely_touching_pairs_of_many_bodies_are_never_missed)
{
    RunScenes("many bodies", UINT64_C(3000000), layout_many, false);
}
END_TEST

START_TEST(pairs_the_margin_apart_in_one_body_are_never_missed)
{
    RunScenes("one body, margin", UINT64_C(4000000), layout_one, true);
}
END_TEST

START_TEST(pairs_the_margin_apart_of_two_bodies_are_never_missed)
{
    RunScenes("two bodies, margin", UINT64_C(5000000), layout_two, true);
}
END_TEST

START_TEST(pairs_the_margin_apart_of_many_bodies_are_never_missed)
{
    RunScenes("many bodies, margin", UINT64_C(6000000), layout_many, true);
}
END_TEST

QC_RUN_TESTS("never miss", barely_touching_pairs_in_one_body_are_never_missed,
             barely_touching_pairs_of_two_bodies_are_never_missed,
             barely_touching_pairs_of_many_bodies_are_never_missed, pairs_the_margin_apart_in_one_body_are_never_missed,
             pairs_the_margin_apart_of_two_bodies_are_never_missed,
             pairs_the_margin_apart_of_many_bodies_are_never_missed)
