// A set of moving boxes: pairs and queries against brute force while boxes are added, moved and removed.
#include "broadphase/box_model.h"
#include "support/failing_heap.h"
#include "support/suite.h"

#include <pthread.h>
#include <stdio.h>

typedef struct Visits
{
    const qcModel* model;
    uint8_t times[qc_modelRoom];
    uint32_t total, limit; ///< limit: the query stops after this many visits
} Visits;

static bool Count(uint32_t id, void* userData, void* context)
{
    Visits* visits = context;
    CHECK_QUICKLY(userData == &visits->model->boxes[id]);
    visits->times[id]++;
    return ++visits->total < visits->limit;
}

static void CheckQuery(const qcModel* model, const double lower[3], const double upper[3])
{
    Visits visits = {.model = model, .limit = UINT32_MAX};
    qcBoxes_QueryBox(model->set, lower, upper, Count, &visits);
    for (uint32_t id = 0; id < model->ends; id++)
    {
        const qcModelBox* box = &model->boxes[id];
        CHECK_QUICKLY(visits.times[id] == (box->alive && qcModel_Overlap(box->lower, box->upper, lower, upper)));
    }
}

/// Compares the overlaps of a box that began since the last search for changes.
static void CheckBegun(const qcModel* model, uint32_t id)
{
    Visits visits = {.model = model, .limit = UINT32_MAX};
    const qcModelBox* box = &model->boxes[id];
    qcBoxes_QueryBegun(model->set, id, Count, &visits);
    for (uint32_t other = 0; other < model->ends; other++)
    {
        const qcModelBox* y = &model->boxes[other];
        bool overlapped = qcModel_Overlapped(model, other < id ? other : id, other < id ? id : other);
        bool begun = box->alive && y->alive && other != id && !overlapped &&
                     qcModel_Overlap(box->lower, box->upper, y->lower, y->upper);
        CHECK_QUICKLY(visits.times[other] == begun);
    }
}

static void CheckList(const qcModel* model)
{
    double lower[3], upper[3], totalLower[3] = {INFINITY, INFINITY, INFINITY},
                               totalUpper[3] = {-INFINITY, -INFINITY, -INFINITY};
    uint32_t count = 0;
    for (uint32_t id = 0; id < model->ends; id++)
    {
        const qcModelBox* box = &model->boxes[id];
        if (!box->alive)
            continue;
        count++;
        CHECK_QUICKLY(qcBoxes_GetUserData(model->set, id) == box);
        qcBoxes_GetBounds(model->set, id, lower, upper);
        CHECK_QUICKLY(memcmp(lower, box->lower, sizeof lower) == 0);
        CHECK_QUICKLY(memcmp(upper, box->upper, sizeof upper) == 0);
        for (int k = 0; k < 3; k++)
        {
            totalLower[k] = fmin(totalLower[k], lower[k]);
            totalUpper[k] = fmax(totalUpper[k], upper[k]);
        }
    }
    ck_assert_uint_eq(qcBoxes_GetCount(model->set), count);
    qcBoxes_GetTotalBounds(model->set, lower, upper);
    for (int k = 0; k < 3; k++)
    {
        ck_assert_double_eq(lower[k], count > 0 ? totalLower[k] : 0.0);
        ck_assert_double_eq(upper[k], count > 0 ? totalUpper[k] : 0.0);
    }
}

//  ---- random worlds ---------------------------------------------------------------------------------

typedef struct World
{
    uint64_t seed;
    int room;        ///< boxes lie within 0 .. room
    bool integers;   ///< many boxes touch, many are flat, segments or points
    bool infinite;   ///< some boxes are infinite, or as large as Bullet's planes
    double restless; ///< fraction of the boxes that move in a step
    bool changes;    ///< search for changed pairs; otherwise for pairs of moved boxes
    double far;      ///< nearly all boxes jump to this distance from zero and back, several times
    double offset;   ///< where new boxes are now
} World;

static void RandomBox(qcRandom* random, const World* world, double lower[3], double upper[3])
{
    for (int k = 0; k < 3; k++)
    {
        if (world->integers)
        {
            lower[k] = qcRandom_Integer(random, 0, world->room);
            upper[k] = lower[k] + qcRandom_Integer(random, 0, 2);
        }
        else
        {
            lower[k] = qcRandom_Uniform(random, 0.0, world->room);
            upper[k] = lower[k] + qcRandom_Uniform(random, 0.0, 2.0);
        }
        lower[k] += k != 1 ? world->offset : -world->offset;
        upper[k] += k != 1 ? world->offset : -world->offset;
        if (!world->infinite)
            continue;
        uint32_t dice = qcRandom_Below(random, 60);
        if (dice < 2)
            lower[k] = dice == 0 ? -INFINITY : -1e18;
        else if (dice < 4)
            upper[k] = dice == 2 ? INFINITY : 1e18;
        else if (dice == 4)
            lower[k] = upper[k] = INFINITY;
        else if (dice == 5)
            lower[k] = upper[k] = -INFINITY;
    }
}

static void StepOne(qcModel* model, qcRandom* random, const World* world, uint32_t id)
{
    qcModelBox* box = &model->boxes[id];
    double lower[3], upper[3];
    switch (qcRandom_Below(random, 8))
    {
        case 0: RandomBox(random, world, lower, upper); break;
        case 1: // the same again
            memcpy(lower, box->lower, sizeof lower);
            memcpy(upper, box->upper, sizeof upper);
            break;
        case 2: // smaller, in place
            for (int k = 0; k < 3; k++)
            {
                lower[k] = box->lower[k];
                upper[k] = world->integers || !isfinite(box->upper[k] - box->lower[k])
                               ? box->lower[k]
                               : box->lower[k] + 0.5 * (box->upper[k] - box->lower[k]);
            }
            break;
        default: // a small step
            for (int k = 0; k < 3; k++)
            {
                double step = world->integers ? qcRandom_Integer(random, -1, 1) : qcRandom_Uniform(random, -0.1, 0.1);
                lower[k] = box->lower[k] + step;
                upper[k] = box->upper[k] + step;
            }
    }
    qcModel_Move(model, id, lower, upper);
}

/// Moves nearly all boxes to another distance from zero.
static void Jump(qcModel* model, qcRandom* random, World* world)
{
    world->offset = world->offset == 0.0 ? world->far : 0.0;
    for (uint32_t id = 0; id < model->ends; id++)
    {
        double lower[3], upper[3];
        RandomBox(random, world, lower, upper);
        if (model->boxes[id].alive && qcRandom_Below(random, 10) != 0)
            qcModel_Move(model, id, lower, upper);
        if (world->changes && qcRandom_Below(random, 20) == 0)
            CheckBegun(model, qcRandom_Below(random, model->ends));
    }
}

static void RunWorld(World* world)
{
    qcRandom random = {world->seed};
    qcModel* model = qcModel_Make();
    double lower[3], upper[3];
    size_t found = 0;
    uint32_t farSteps = 0;
    for (int step = 0; step < 120; step++)
    {
        if (world->far != 0.0 && step % 16 == 15)
            Jump(model, &random, world);
        farSteps += world->offset != 0.0 && model->set->origin.isSet;
        uint32_t additions = qcRandom_Below(&random, step < 20 ? 25 : step % 10 < 8 ? 7 : 1);
        for (uint32_t i = 0; i < additions; i++)
        {
            RandomBox(&random, world, lower, upper);
            qcModel_Add(model, lower, upper);
        }
        for (uint32_t id = 0; id < model->ends; id++)
        {
            if (!model->boxes[id].alive)
                continue;
            if (qcRandom_Uniform(&random, 0.0, 1.0) < world->restless)
                StepOne(model, &random, world, id);
            // Between moves too: others may be inserted after this box's overlaps were found.
            if (world->changes && qcRandom_Below(&random, 20) == 0)
                CheckBegun(model, qcRandom_Below(&random, model->ends));
            if (qcRandom_Below(&random, 60) == 0)
                qcModel_Remove(model, id);
        }
        if (step == 80)
        {
            qcBoxes_Clear(model->set);
            CHECK_QUICKLY(!model->set->origin.isSet);
            memset(model->boxes, 0, sizeof model->boxes);
            memset(model->overlapped, 0, sizeof model->overlapped);
            model->ends = 0;
        }
        qcModel_CheckForest(model);
        CheckList(model);
        for (int i = 0; i < 5; i++)
        {
            RandomBox(&random, world, lower, upper);
            CheckQuery(model, lower, upper);
        }
        for (int i = 0; world->changes && i < 20; i++)
            CheckBegun(model, qcRandom_Below(&random, model->ends + 2));
        // Sometimes changes gather over two steps.
        if (qcRandom_Below(&random, 4) != 0)
            found += world->changes ? qcModel_CheckChangedPairs(model) : qcModel_CheckMovedPairs(model);
    }
    ck_assert_uint_gt(found, world->changes ? 500 : 1000);
    ck_assert(world->far == 0.0 || world->infinite || farSteps > 20);
    qcModel_Free(model);
}

static void RunAllWorlds(bool changes)
{
    for (uint64_t seed = 1; seed <= 3; seed++)
    {
        World worlds[] = {
            {.seed = seed, .room = 10, .restless = 0.9, .changes = changes},
            {.seed = seed, .room = 8, .restless = 0.05, .changes = changes},
            {.seed = seed, .room = 8, .integers = true, .restless = 0.5, .changes = changes},
            {.seed = seed, .room = 12, .infinite = true, .restless = 0.5, .changes = changes},
            {.seed = seed, .room = 8, .integers = true, .infinite = true, .restless = 0.1, .changes = changes},
            {.seed = seed, .room = 10, .restless = 0.9, .changes = changes, .far = 1e9},
            {.seed = seed, .room = 8, .restless = 0.05, .changes = changes, .far = 1e8},
            {.seed = seed, .room = 8, .integers = true, .restless = 0.1, .changes = changes, .far = 1e9 + 1},
            {.seed = seed, .room = 12, .infinite = true, .restless = 0.5, .changes = changes, .far = 1e12},
        };
        for (size_t i = 0; i < sizeof worlds / sizeof *worlds; i++)
            RunWorld(&worlds[i]);
    }
}

START_TEST(pairs_and_queries_equal_brute_force_whatever_changes)
{
    RunAllWorlds(false);
}
END_TEST

START_TEST(what_began_and_what_ended_equals_brute_force_whatever_changes)
{
    RunAllWorlds(true);
}
END_TEST

//  ---- pairs -----------------------------------------------------------------------------------------

START_TEST(boxes_that_share_a_face_an_edge_or_a_corner_are_pairs)
{
    for (int x = -1; x <= 1; x++)
        for (int y = -1; y <= 1; y++)
            for (int z = -1; z <= 1; z++)
                for (int apart = 0; apart <= 1; apart++)
                {
                    qcModel* model = qcModel_Make();
                    double lower[3] = {x, y, z}, upper[3] = {x + 1, y + 1, z + 1};
                    // The smallest distance that doubles can have without touching.
                    if (apart)
                        lower[0] = nextafter(1.0, 2.0), upper[0] = 2.0;
                    qcModel_Add(model, (double[3]){0, 0, 0}, (double[3]){1, 1, 1});
                    qcModel_Add(model, lower, upper);
                    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), !apart);
                    qcModel_Free(model);
                }
}
END_TEST

START_TEST(a_step_shorter_than_the_spacing_of_floats_begins_and_ends_a_pair)
{
    qcModel* model = qcModel_Make();
    for (int i = 0; i < 10; i++)
        qcModel_Add(model, (double[3]){10 * i, 0, 0}, (double[3]){10 * i + 0.1, 0.1, 0.1});
    qcModel_CheckChangedPairs(model);
    for (uint32_t step = 0; step < 20; step++)
    {
        // Next to the first one and a trillionth away from it in turns; in between a move that changes nothing.
        double apart = step / 2 % 2 == 0 ? 0.0 : 1e-12;
        qcModel_Move(model, 1, (double[3]){0.1 + apart, 0, 0}, (double[3]){0.2, 0.1 + step * 1e-3, 0.1});
        CheckBegun(model, step % 3);
        ck_assert_uint_eq(qcModel_CheckChangedPairs(model), step % 2 == 0);
    }
    qcModel_Free(model);
}
END_TEST

START_TEST(a_pair_is_reported_only_when_one_of_the_two_moved)
{
    qcModel* model = qcModel_Make();
    const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1}, half[3] = {0.5, 0.5, 0.5}, most[3] = {0.9, 0.9, 0.9};
    qcModel_Add(model, zero, one);
    qcModel_Add(model, zero, half);
    qcModel_Add(model, half, one);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 3);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 0);
    qcModel_Move(model, 1, zero, half);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 0);
    // Smaller, within its previous bounds: a move like any other.
    qcModel_Move(model, 2, half, most);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 2);
    qcModel_Move(model, 2, half, most);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 0);
    qcModel_Free(model);
}
END_TEST

START_TEST(a_removed_box_is_in_no_pair)
{
    qcModel* model = qcModel_Make();
    const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1}, two[3] = {2, 2, 2}, three[3] = {3, 3, 3};
    for (int i = 0; i < 4; i++)
        qcModel_Add(model, zero, one);
    qcModel_Remove(model, 1);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 3);
    qcModel_Move(model, 0, one, two);
    qcModel_Remove(model, 0);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 0);
    // Id 0 again, far away: it must not inherit overlaps.
    qcModel_Add(model, two, three);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 0);
    qcModel_Free(model);
}
END_TEST

START_TEST(thousands_of_boxes_in_one_place_are_all_pairs)
{
    qcModel* model = qcModel_Make();
    const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1}, far[3] = {5, 5, 5};
    for (uint32_t i = 0; i < 2000; i++)
        qcModel_Add(model, zero, one);
    qcModel_CheckForest(model);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 2000 * 1999 / 2);
    for (uint32_t i = 0; i < 1990; i++)
        qcModel_Move(model, i, i % 2 ? zero : far, far);
    qcModel_CheckForest(model);
    qcModel_CheckMovedPairs(model);
    for (uint32_t i = 0; i < 2000; i++)
        qcModel_Remove(model, i);
    qcModel_CheckForest(model);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 0);
    qcModel_Free(model);
}
END_TEST

/// Number of octets that a point query visits.
static uint32_t CountOctets(const qcModel* model, const double point[3])
{
    const qcForest* forest = &model->set->forest;
    uint32_t visited = (uint32_t)(forest->listIds.count + qc_lanes - 1) / qc_lanes;
    qcFloatBox box;
    (void)qcBoxOrigin_Enclose(&model->set->origin, &box, point, point);
    for (uint64_t trees = forest->staticTrees | forest->dynamicTrees; trees != 0;)
    {
        const qcBoxTree* tree = &forest->trees[qcForest_NextTree(&trees)];
        visited++; // the root
        uint32_t levels = tree->shape.levelCount;
        for (uint32_t at = tree->shape.first[1]; levels > 1 && at <= tree->shape.first[levels - 1]; at++)
            visited += (uint32_t)__builtin_popcount(forest->kernels->overlap(&tree->shape.octets[at], &box));
    }
    return visited;
}

START_TEST(points_in_one_line_and_in_one_place_are_found)
{
    qcModel* model = qcModel_Make();
    for (uint32_t i = 0; i < 1000; i++)
    {
        double point[3] = {i / 2, 0, 0};
        qcModel_Add(model, point, point);
    }
    qcModel_CheckForest(model);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 500);
    CheckQuery(model, (double[3]){250, 0, 0}, (double[3]){251, 0, 0});
    // A query visits few of a thousand.
    ck_assert_uint_le(CountOctets(model, (double[3]){250, 0, 0}), 12);
    qcModel_Free(model);
}
END_TEST

START_TEST(infinite_boxes_do_not_spoil_the_tree)
{
    qcModel* model = qcModel_Make();
    qcRandom random = {7};
    const double minus[3] = {-INFINITY, -INFINITY, -INFINITY}, plus[3] = {INFINITY, INFINITY, INFINITY};
    for (uint32_t i = 0; i < 3000; i++)
    {
        double lower[3], upper[3];
        for (int k = 0; k < 3; k++)
        {
            lower[k] = qcRandom_Uniform(&random, 0.0, 100.0);
            upper[k] = lower[k] + 1.0;
        }
        if (i % 600 == 0)
            qcModel_Add(model, minus, plus);
        qcModel_Add(model, lower, upper);
    }
    qcModel_CheckForest(model);
    qcModel_CheckMovedPairs(model);
    // 5 infinite boxes share an octet; among the others they would open most of 400.
    const double point[3] = {50, 50, 50}, outside[3] = {1e9, 0, 0};
    ck_assert_uint_le(CountOctets(model, point), 25);
    ck_assert_uint_le(CountOctets(model, outside), 10);
    qcModel_Free(model);
}
END_TEST

/// Adds boxes of edge 0.5 at a distance from zero and moves them, with a search after each step or only after the last.
/// Returns the pairs compared in all searches.
static size_t MoveCrowd(double distance, bool search)
{
    enum
    {
        count = 2000
    };
    qcModel* model = qcModel_Make();
    qcRandom random = {8};
    size_t compared = 0, queried = 0;
    for (int step = 0; step < 4; step++)
        for (uint32_t id = 0; id <= count; id++)
        {
            double lower[3], upper[3];
            for (int k = 0; k < 3 && id < count; k++)
            {
                lower[k] = step == 0 ? distance + qcRandom_Uniform(&random, 0.0, 26.0)
                                     : model->boxes[id].lower[k] + qcRandom_Uniform(&random, -0.05, 0.05);
                upper[k] = lower[k] + 0.5;
            }
            if (id < count && step == 0)
                qcModel_Add(model, lower, upper);
            else if (id < count)
                qcModel_Move(model, id, lower, upper);
            else if (search || step == 3)
            {
                qcModel_CheckMovedPairs(model);
                compared += qcBoxes_GetProfile(model->set).compared;
            }
        }
    qcModel_CheckForest(model);
    for (uint32_t id = 0; id < count; id += 50)
    {
        CheckQuery(model, model->boxes[id].lower, model->boxes[id].upper);
        queried += CountOctets(model, model->boxes[id].lower);
    }
    ck_assert_uint_le(queried, 40 * 20);
    qcModel_Free(model);
    return compared;
}

START_TEST(a_crowd_far_from_zero_is_compared_as_little_as_one_near_it)
{
    static const double distances[] = {1e7, -1e8, 1e9, 1e12};
    for (int search = 0; search <= 1; search++)
    {
        size_t near = MoveCrowd(0.0, search);
        for (size_t i = 0; i < sizeof distances / sizeof *distances; i++)
            ck_assert_uint_le(MoveCrowd(distances[i], search), near + near / 2);
    }
}
END_TEST

//  ---- the contract ----------------------------------------------------------------------------------

START_TEST(ids_are_reused_lowest_first)
{
    qcModel* model = qcModel_Make();
    const double zero[3] = {0, 0, 0};
    for (uint32_t i = 0; i < 100; i++)
        ck_assert_uint_eq(qcModel_Add(model, zero, zero), i);
    static const uint32_t freed[] = {50, 3, 99, 7, 0, 64, 12};
    static const uint32_t expected[] = {0, 3, 7, 12, 50, 64, 99, 100};
    for (size_t i = 0; i < sizeof freed / sizeof *freed; i++)
        qcModel_Remove(model, freed[i]);
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++)
        ck_assert_uint_eq(qcModel_Add(model, zero, zero), expected[i]);
    qcModel_Free(model);
}
END_TEST

static void Refused(qcStatus status, const char* place)
{
    ck_assert_int_eq(status, qc_statusBadInput);
    ck_assert_msg(strstr(qcLastMessage(), place) != NULL, "\"%s\" does not name \"%s\"", qcLastMessage(), place);
}

START_TEST(bad_input_is_refused_and_changes_nothing)
{
    qcModel* model = qcModel_Make();
    const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    qcModel_Add(model, zero, one);
    qcModel_Add(model, zero, one);
    qcModel_CheckMovedPairs(model);
    uint32_t id = 77;
    for (int k = 0; k < 3; k++)
        for (int kind = 0; kind < 3; kind++)
        {
            double lower[3] = {0, 0, 0}, upper[3] = {1, 1, 1};
            char place[32];
            snprintf(place, sizeof place, "lower[%d]", k);
            if (kind < 2)
                (kind == 0 ? lower : upper)[k] = NAN;
            else
                lower[k] = 2.0;
            Refused(qcBoxes_Add(model->set, lower, upper, NULL, &id), place);
            Refused(qcBoxes_Move(model->set, 0, lower, upper), place);
        }
    Refused(qcBoxes_Create(NULL), "boxes is null");
    Refused(qcBoxes_Add(NULL, zero, one, NULL, &id), "null");
    Refused(qcBoxes_Add(model->set, zero, one, NULL, NULL), "null");
    Refused(qcBoxes_Add(model->set, NULL, one, NULL, &id), "null");
    Refused(qcBoxes_Move(model->set, 0, zero, NULL), "null");
    Refused(qcBoxes_Move(model->set, 2, zero, one), "box 2");
    Refused(qcBoxes_Remove(model->set, 2), "box 2");
    Refused(qcBoxes_Remove(NULL, 0), "box 0");
    Refused(qcBoxes_FindMovedPairs(model->set, NULL, NULL), "null");
    Refused(qcBoxes_FindChangedPairs(model->set, NULL), "null");
    ck_assert_uint_eq(id, 77);
    ck_assert_ptr_null(qcBoxes_GetUserData(model->set, 2));
    CheckList(model);
    qcModel_CheckForest(model);
    ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 0);
    qcModel_Free(model);
    qcBoxes_Destroy(NULL);
    qcBoxes_Clear(NULL);
}
END_TEST

START_TEST(a_query_ends_when_the_function_returns_false)
{
    qcModel* model = qcModel_Make();
    const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    for (uint32_t i = 0; i < 50; i++)
        qcModel_Add(model, zero, one);
    Visits visits = {.model = model, .limit = 7};
    qcBoxes_QueryBox(model->set, zero, one, Count, &visits);
    ck_assert_uint_eq(visits.total, 7);
    visits = (Visits){.model = model, .limit = 9};
    qcBoxes_CastBox(model->set, zero, one, zero, zero, NULL, Count, &visits);
    ck_assert_uint_eq(visits.total, 9);
    qcModel_Free(model);
}
END_TEST

static void* AskMany(void* context)
{
    const qcModel* model = context;
    qcRandom random = {11};
    for (int i = 0; i < 300; i++)
    {
        double lower[3], upper[3];
        RandomBox(&random, &(World){.room = 10}, lower, upper);
        CheckQuery(model, lower, upper);
    }
    return NULL;
}

START_TEST(several_threads_may_query_at_once)
{
    qcModel* model = qcModel_Make();
    qcRandom random = {5};
    for (int i = 0; i < 500; i++)
    {
        double lower[3], upper[3];
        RandomBox(&random, &(World){.room = 10}, lower, upper);
        qcModel_Add(model, lower, upper);
    }
    pthread_t threads[4];
    for (int i = 0; i < 4; i++)
        ck_assert_int_eq(pthread_create(&threads[i], NULL, AskMany, model), 0);
    for (int i = 0; i < 4; i++)
        pthread_join(threads[i], NULL);
    qcModel_Free(model);
}
END_TEST

/// A cloud of boxes: enough for every array to grow. Returns whether a call ran out of memory.
static bool GrowCloud(qcBoxes* set, uint32_t step, double far)
{
    bool failed = false;
    for (uint32_t i = 0; i < 300; i++)
    {
        double lower[3] = {i % 30 + step * (0.25 + far), i / 30, 0}, upper[3] = {lower[0] + 1, lower[1] + 1, 1};
        uint32_t id = i;
        qcStatus status = step == 0 ? qcBoxes_Add(set, lower, upper, NULL, &id) : qcBoxes_Move(set, i, lower, upper);
        if (status != qc_statusOk)
        {
            failed = true;
            ck_assert_int_eq(status, qc_statusOutOfMemory);
            ck_assert_uint_eq(qcBoxes_GetCount(set), i);
            ck_assert_uint_eq(step, 0); // moving needs no memory
            CHECK_OK(qcBoxes_Add(set, lower, upper, NULL, &id));
        }
        CHECK_QUICKLY(id == i);
    }
    return failed;
}

/// Returns whether a search ran out of memory; the next search finds all pairs.
static bool SearchCloud(qcBoxes* set, uint32_t step, bool changes)
{
    // Neighbours in a grid of 30 by 10, diagonal ones included.
    const size_t expected = 29 * 10 + 30 * 9 + 2 * 29 * 9;
    const qcBoxPair* pairs;
    qcBoxChanges found;
    size_t count;
    bool failed = false;
    qcStatus status = changes ? qcBoxes_FindChangedPairs(set, &found) : qcBoxes_FindMovedPairs(set, &pairs, &count);
    if (status != qc_statusOk)
    {
        failed = true;
        ck_assert_int_eq(status, qc_statusOutOfMemory);
        CHECK_OK(changes ? qcBoxes_FindChangedPairs(set, &found) : qcBoxes_FindMovedPairs(set, &pairs, &count));
        ck_assert(!changes || found.all);
    }
    if (!changes)
        ck_assert_uint_eq(count, expected);
    else
    {
        // All move together: nothing changes in the second step.
        ck_assert_uint_eq(found.beganCount, step == 0 || found.all ? expected : 0);
        ck_assert_uint_eq(found.endedCount, 0);
    }
    return failed;
}

START_TEST(out_of_memory_is_a_status_and_the_next_try_finds_everything)
{
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    for (int way = 0; way < 4; way++)
    {
        bool changes = way % 2 != 0;
        // In the second step near zero, or far from it.
        double far = way < 2 ? 0.0 : 1e9;
        size_t failures = 0, successes = 0;
        // Some failures are harmless: trees stay unmerged, lists long.
        for (size_t failAt = 1; successes < 5; failAt++)
        {
            heap = (qcFailingHeap){heap.live, 0, failAt};
            qcBoxes* set;
            bool failed = qcBoxes_Create(&set) != qc_statusOk;
            if (failed)
            {
                ck_assert_uint_eq(qcGetByteCount(), 0);
                CHECK_OK(qcBoxes_Create(&set));
            }
            for (uint32_t step = 0; step < 2; step++)
            {
                failed = GrowCloud(set, step, far) || failed;
                failed = SearchCloud(set, step, changes) || failed;
            }
            qcBoxes_Destroy(set);
            ck_assert_uint_eq(qcGetByteCount(), 0);
            failures += failed;
            successes = failed ? 0 : successes + 1;
        }
        ck_assert_uint_gt(failures, 15);
    }
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}
END_TEST

QC_RUN_TESTS("boxes", pairs_and_queries_equal_brute_force_whatever_changes,
             what_began_and_what_ended_equals_brute_force_whatever_changes,
             boxes_that_share_a_face_an_edge_or_a_corner_are_pairs,
             a_step_shorter_than_the_spacing_of_floats_begins_and_ends_a_pair,
             a_pair_is_reported_only_when_one_of_the_two_moved, a_removed_box_is_in_no_pair,
             thousands_of_boxes_in_one_place_are_all_pairs, points_in_one_line_and_in_one_place_are_found,
             infinite_boxes_do_not_spoil_the_tree, a_crowd_far_from_zero_is_compared_as_little_as_one_near_it,
             ids_are_reused_lowest_first, bad_input_is_refused_and_changes_nothing,
             a_query_ends_when_the_function_returns_false, several_threads_may_query_at_once,
             out_of_memory_is_a_status_and_the_next_try_finds_everything)
