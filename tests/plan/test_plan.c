// The planner is a pure function of its input.
#include "plan/plan.h"
#include "support/suite.h"

#include <math.h>

static const qcPlanCosts s_deviceIsQuick = {0.0004, 0.5, 0.0001};
static const qcPlanCosts s_deviceIsSlow = {0.0001, 0.5, 0.0004};
static const qcPlanCosts s_deviceFails = {0.0, INFINITY, INFINITY};

/// An island within [at, at + size] along each axis.
static qcPlanItem Island(uint32_t triangles, double at, double size)
{
    return (qcPlanItem){.triangles = triangles,
                        .lower = {at, at, at},
                        .upper = {at + size, at + size, at + size},
                        .finest = size / sqrt(triangles),
                        .onDevice = false};
}

/// The choice for the first query of a scene.
static void Choose(const qcPlanCosts* costs, qcPlanItem* islands, size_t count)
{
    qcPlanHistory history = {.queries = 0};
    double triangles;
    qcPlan_ChooseIslands(costs, &history, islands, count, &triangles);
}

/// Total milliseconds of queries at the scene's actual costs.
static double RunSized(qcPlanHistory* history, const qcPlanCosts* calibrated, const qcPlanCosts* actual,
                       double triangles, int queries)
{
    double sum = 0.0;
    for (int i = 0; i < queries; i++)
    {
        bool onDevice = qcPlanHistory_Choose(history, calibrated, triangles);
        double ms = onDevice ? actual->layersFixed + triangles * actual->layersPerTriangle
                             : triangles * actual->sweepPerTriangle;
        qcPlanHistory_Add(history, onDevice, triangles, ms);
        sum += ms;
    }
    return sum;
}

/// Queries of 20000 triangles each.
static double RunQueries(qcPlanHistory* history, const qcPlanCosts* calibrated, const qcPlanCosts* actual, int queries)
{
    return RunSized(history, calibrated, actual, 20000.0, queries);
}

START_TEST(auto_is_the_sweep_without_compute_shaders)
{
    qcPlanInput input = {.method = qc_methodAuto, .haveGl = true, .haveCompute = false};
    qcPlan plan = qcPlan_Make(&input);
    ck_assert_int_eq(plan.method, qc_methodSweep);
    ck_assert(!plan.chooseIslands && !plan.useLayers && !plan.useImage);
    ck_assert_ptr_null(plan.fallback);
}
END_TEST

START_TEST(auto_chooses_by_island_with_compute_shaders)
{
    qcPlanInput input = {.method = qc_methodAuto, .haveGl = true, .haveCompute = true};
    qcPlan plan = qcPlan_Make(&input);
    ck_assert(plan.chooseIslands);
    ck_assert(!plan.useLayers);
}
END_TEST

START_TEST(layers_without_compute_shaders_fall_back_to_the_sweep)
{
    qcPlanInput input = {.method = qc_methodLayers, .haveGl = true, .haveCompute = false};
    qcPlan plan = qcPlan_Make(&input);
    ck_assert_int_eq(plan.method, qc_methodSweep);
    ck_assert_ptr_nonnull(plan.fallback);
    input.haveCompute = true;
    plan = qcPlan_Make(&input);
    ck_assert_int_eq(plan.method, qc_methodLayers);
    ck_assert(plan.useLayers);
    ck_assert_ptr_null(plan.fallback);
}
END_TEST

START_TEST(few_triangles_stay_off_the_device)
{
    qcPlanItem islands[2] = {Island(100, 0.0, 1.0), Island(100, 2.0, 1.0)};
    ck_assert(!qcPlan_IsWorthADevice(islands, 2));
    islands[1].triangles = 100000;
    ck_assert(qcPlan_IsWorthADevice(islands, 2));
    ck_assert(!qcPlan_IsWorthADevice(islands, 0));
}
END_TEST

START_TEST(islands_go_to_the_device_when_that_saves_more_than_the_transfer)
{
    // The transfer pays from 0.5 / (0.0004 - 0.0001) = 1667 triangles on.
    qcPlanItem islands[2] = {Island(1000, 0.0, 1.0), Island(600, 2.0, 1.0)};
    Choose(&s_deviceIsQuick, islands, 2);
    ck_assert(!islands[0].onDevice && !islands[1].onDevice);
    islands[1].triangles = 700;
    Choose(&s_deviceIsQuick, islands, 2);
    ck_assert(islands[0].onDevice && islands[1].onDevice);
}
END_TEST

START_TEST(no_island_goes_to_a_device_that_is_slower_or_fails)
{
    qcPlanItem islands[2] = {Island(1000000, 0.0, 1.0), Island(600, 2.0, 1.0)};
    Choose(&s_deviceIsSlow, islands, 2);
    ck_assert(!islands[0].onDevice && !islands[1].onDevice);
    Choose(&s_deviceFails, islands, 2);
    ck_assert(!islands[0].onDevice && !islands[1].onDevice);
}
END_TEST

START_TEST(an_island_too_small_for_the_common_grid_stays_with_the_sweep)
{
    // 1e-6 of the grid is a thirtieth of a level, for 5000 triangles.
    qcPlanItem islands[2] = {Island(100000, 0.0, 1000.0), Island(5000, 500.0, 0.001)};
    Choose(&s_deviceIsQuick, islands, 2);
    ck_assert(islands[0].onDevice);
    ck_assert(!islands[1].onDevice);
}
END_TEST

START_TEST(a_fine_body_on_a_wide_ground_stays_with_the_sweep)
{
    // The triangles of a cloth of 1 m on a ground of 20 km.
    qcPlanItem island = Island(10000, 0.0, 20000.0);
    island.finest = 0.01;
    Choose(&s_deviceIsQuick, &island, 1);
    ck_assert(!island.onDevice);
}
END_TEST

START_TEST(islands_without_extent_stay_with_the_sweep)
{
    qcPlanItem island = Island(100000, 3.0, 0.0);
    Choose(&s_deviceIsQuick, &island, 1);
    ck_assert(!island.onDevice);
}
END_TEST

START_TEST(a_method_that_is_slower_than_calibrated_costs_no_more_than_a_trial)
{
    // The sweep takes 0.6 ms here and layers 2.7; the calibration has the opposite.
    const qcPlanCosts actual = {0.00003, 0.0, 0.000135}, mirrored = {0.000135, 0.0, 0.00003};
    for (int fastest = 0; fastest < 2; fastest++)
    {
        const qcPlanCosts* costs = fastest == 0 ? &actual : &mirrored;
        const qcPlanCosts* calibrated = fastest == 0 ? &mirrored : &actual;
        qcPlanHistory history = {.queries = 0};
        RunQueries(&history, calibrated, costs, 30);
        double ms = RunQueries(&history, calibrated, costs, 10000);
        ck_assert_double_le(ms, 1.1 * 10000 * 0.6);
    }
}
END_TEST

/// Total milliseconds of the queries of a scene, each method's own: the first ones of a method take many times as long,
/// and other processes delay one query in ten. Delays don't count: they would be the same for any choice.
static double RunDelayed(const qcPlanCosts* calibrated, const qcPlanCosts* actual, int queries)
{
    const double triangles = 20000.0;
    qcPlanHistory history = {.queries = 0};
    uint64_t random = 1;
    uint32_t ran[2] = {0, 0};
    double sum = 0.0;
    for (int i = 0; i < queries; i++)
    {
        bool onDevice = qcPlanHistory_Choose(&history, calibrated, triangles);
        double ms = triangles * (onDevice ? actual->layersPerTriangle : actual->sweepPerTriangle);
        if (ran[onDevice]++ == 0)
            ms *= 10.0;
        sum += ms;
        random = random * 6364136223846793005u + 1442695040888963407u;
        qcPlanHistory_Add(&history, onDevice, triangles, (random >> 33) % 10 == 0 ? ms + 5.0 : ms);
    }
    return sum;
}

START_TEST(delays_and_first_queries_cost_less_than_a_tenth)
{
    // A folding cloth on two cores: sweep 0.6 ms, layers 1.1; calibrated 1.2 and 0.9.
    const qcPlanCosts actual = {0.00003, 0.0, 0.000055}, calibrated = {0.00006, 0.3, 0.00003};
    const qcPlanCosts mirrored = {0.000055, 0.0, 0.00003}, mirroredCalibrated = {0.00003, 0.0, 0.00006};
    const int counts[] = {100, 360, 3000};
    for (int i = 0; i < 3; i++)
    {
        double best = (counts[i] + 9) * 0.6;
        ck_assert_double_le(RunDelayed(&actual, &actual, counts[i]), 1.1 * best);
        ck_assert_double_le(RunDelayed(&mirrored, &mirrored, counts[i]), 1.1 * best);
    }
    // A wrong calibration costs a trial, and the method's first query.
    ck_assert_double_le(RunDelayed(&calibrated, &actual, 3000), 1.1 * 3009 * 0.6);
    ck_assert_double_le(RunDelayed(&mirroredCalibrated, &mirrored, 3000), 1.1 * 3009 * 0.6);
}
END_TEST

START_TEST(a_method_far_slower_than_calibrated_is_left_soon)
{
    // 105 frames of falling leaves: the sweep takes four times its calibrated cost, since they move far.
    const qcPlanCosts calibrated = {0.00003, 0.0, 0.00005}, actual = {0.00012, 0.0, 0.00005};
    qcPlanHistory history = {.queries = 0};
    RunQueries(&history, &calibrated, &actual, 20);
    ck_assert_uint_lt(history.sweep.count, 11);
    RunQueries(&history, &calibrated, &actual, 85);
    ck_assert(history.onDevice);
    ck_assert_uint_lt(history.sweep.count, 20);
    // Ten times: it is not tried again for hundreds of queries.
    const qcPlanCosts slow = {0.0005, 0.0, 0.00005};
    history = (qcPlanHistory){.queries = 0};
    ck_assert_double_le(RunQueries(&history, &calibrated, &slow, 500), (500 + 6 * 9) * 1.0);
}
END_TEST

START_TEST(a_method_that_takes_twice_its_estimate_is_compared_after_a_few_queries)
{
    // 52 frames of a fracture on a GPU, 16 threads: calibrated on small deforming sheets, the sweep seems as slow as
    // layers turns out to be.
    const double triangles = 473420.0;
    const qcPlanCosts calibrated = {0.000012, 0.08, 0.000005}, actual = {0.0000037, 0.0, 0.0000116};
    qcPlanHistory history = {.queries = 0};
    int onDevice = 0;
    for (int i = 0; i < 52; i++)
    {
        bool isOnDevice = qcPlanHistory_Choose(&history, &calibrated, triangles);
        onDevice += isOnDevice;
        qcPlanHistory_Add(&history, isOnDevice, triangles,
                          triangles * (isOnDevice ? actual.layersPerTriangle : actual.sweepPerTriangle));
    }
    ck_assert_int_gt(onDevice, 0);
    ck_assert_int_le(onDevice, 20);
}
END_TEST

START_TEST(a_lost_trial_ends_early)
{
    // The scheduled trial of layers at query 128, and no other up to 500: sweep 0.6 ms, layers 0.8.
    const qcPlanCosts costs = {0.00003, 0.0, 0.00004};
    qcPlanHistory history = {.queries = 0};
    RunQueries(&history, &costs, &costs, qc_firstTrial);
    ck_assert_uint_eq(history.layers.count, 0);
    RunQueries(&history, &costs, &costs, 500 - qc_firstTrial);
    ck_assert_uint_eq(history.layers.count, qc_lostQueries);
    ck_assert(!history.onDevice);
    // At twice the cost and more one query less is enough.
    const qcPlanCosts clear = {0.00003, 0.0, 0.00004}, actual = {0.00003, 0.0, 0.00009};
    history = (qcPlanHistory){.queries = 0};
    RunQueries(&history, &clear, &actual, 500);
    ck_assert_uint_eq(history.layers.count, qc_lostQueries - 1);
}
END_TEST

START_TEST(a_sweep_that_would_take_many_times_as_long_is_never_tried)
{
    qcPlanHistory history = {.queries = 0};
    const qcPlanCosts costs = {0.0005, 0.0, 0.0001};
    RunQueries(&history, &costs, &costs, 20000);
    ck_assert_uint_eq(history.sweep.count, 0);
}
END_TEST

START_TEST(a_scene_that_changes_switches_method_after_its_next_trial)
{
    qcPlanHistory history = {.queries = 0};
    const qcPlanCosts first = {0.00005, 0.0, 0.00011}, later = {0.0004, 0.0, 0.0001};
    RunQueries(&history, &s_deviceIsQuick, &first, 1000);
    ck_assert(!history.onDevice);
    RunQueries(&history, &s_deviceIsQuick, &later, 2 * qc_maxTrialGap);
    ck_assert(history.onDevice);
}
END_TEST

START_TEST(a_scene_that_changes_its_size_is_judged_at_the_new_one)
{
    // A device with a large fixed cost is the faster one from 20000 triangles on.
    const qcPlanCosts costs = {0.0001, 1.8, 0.00001};
    qcPlanHistory history = {.queries = 0};
    for (int i = 0; i < 3; i++)
    {
        RunSized(&history, &costs, &costs, 200000.0, 20);
        ck_assert(history.onDevice);
        // With the trial that confirms the switch: the next one is hundreds of queries away.
        RunSized(&history, &costs, &costs, 15000.0, 4 * qc_confirmGap);
        ck_assert(!history.onDevice);
    }
}
END_TEST

QC_RUN_TESTS("plan", a_method_that_is_slower_than_calibrated_costs_no_more_than_a_trial,
             a_method_far_slower_than_calibrated_is_left_soon, delays_and_first_queries_cost_less_than_a_tenth,
             a_method_that_takes_twice_its_estimate_is_compared_after_a_few_queries, a_lost_trial_ends_early,
             a_sweep_that_would_take_many_times_as_long_is_never_tried,
             a_scene_that_changes_switches_method_after_its_next_trial,
             a_scene_that_changes_its_size_is_judged_at_the_new_one, auto_is_the_sweep_without_compute_shaders,
             auto_chooses_by_island_with_compute_shaders, layers_without_compute_shaders_fall_back_to_the_sweep,
             few_triangles_stay_off_the_device, islands_go_to_the_device_when_that_saves_more_than_the_transfer,
             no_island_goes_to_a_device_that_is_slower_or_fails,
             an_island_too_small_for_the_common_grid_stays_with_the_sweep,
             a_fine_body_on_a_wide_ground_stays_with_the_sweep, islands_without_extent_stay_with_the_sweep)
