// The planner is a pure function: what it chooses follows from its input alone.
#include "plan/plan.h"
#include "support/suite.h"

#include <math.h>

static const qcPlanCosts s_deviceIsQuick = {0.0004, 0.5, 0.0001};
static const qcPlanCosts s_deviceIsSlow = {0.0001, 0.5, 0.0004};
static const qcPlanCosts s_deviceFails = {0.0, INFINITY, INFINITY};

/// A part within [at, at + size] along each axis.
static qcPlanItem Part(uint32_t triangles, double at, double size)
{
    return (qcPlanItem){
        .triangles = triangles, .lower = {at, at, at}, .upper = {at + size, at + size, at + size}, .onDevice = false};
}

/// As in the first query of a scene.
static void Choose(const qcPlanCosts* costs, qcPlanItem* parts, size_t count)
{
    qcPlanHistory history = {.queries = 0};
    double triangles;
    qcPlan_ChooseParts(costs, &history, parts, count, &triangles);
}

/// Milliseconds of so many queries of 20000 triangles, by what they cost in this scene.
static double RunQueries(qcPlanHistory* history, const qcPlanCosts* calibrated, const qcPlanCosts* actual, int queries)
{
    const double triangles = 20000.0;
    double sum = 0.0;
    for (int i = 0; i < queries; i++)
    {
        bool onDevice = qcPlanHistory_Choose(history, calibrated, triangles);
        double ms = triangles * (onDevice ? actual->layersPerTriangle : actual->sweepPerTriangle);
        qcPlanHistory_Add(history, onDevice, triangles, ms);
        sum += ms;
    }
    return sum;
}

START_TEST(auto_is_the_sweep_without_compute_shaders)
{
    qcPlanInput input = {.method = qc_methodAuto, .haveGl = true, .haveCompute = false};
    qcPlan plan = qcPlan_Make(&input);
    ck_assert_int_eq(plan.method, qc_methodSweep);
    ck_assert(!plan.chooseParts && !plan.useLayers && !plan.useImage);
    ck_assert_ptr_null(plan.fallback);
}
END_TEST

START_TEST(auto_looks_at_parts_where_there_are_compute_shaders)
{
    qcPlanInput input = {.method = qc_methodAuto, .haveGl = true, .haveCompute = true};
    qcPlan plan = qcPlan_Make(&input);
    ck_assert(plan.chooseParts);
    ck_assert(!plan.useLayers);
}
END_TEST

START_TEST(layers_without_compute_shaders_fall_back_and_say_so)
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

START_TEST(few_triangles_are_not_worth_a_device)
{
    qcPlanItem parts[2] = {Part(100, 0.0, 1.0), Part(100, 2.0, 1.0)};
    ck_assert(!qcPlan_IsWorthADevice(parts, 2));
    parts[1].triangles = 100000;
    ck_assert(qcPlan_IsWorthADevice(parts, 2));
    ck_assert(!qcPlan_IsWorthADevice(parts, 0));
}
END_TEST

START_TEST(parts_go_to_the_device_when_that_saves_more_than_the_trip)
{
    // The trip pays from 0.5 / (0.0004 - 0.0001) = 1667 triangles on.
    qcPlanItem parts[2] = {Part(1000, 0.0, 1.0), Part(600, 2.0, 1.0)};
    Choose(&s_deviceIsQuick, parts, 2);
    ck_assert(!parts[0].onDevice && !parts[1].onDevice);
    parts[1].triangles = 700;
    Choose(&s_deviceIsQuick, parts, 2);
    ck_assert(parts[0].onDevice && parts[1].onDevice);
}
END_TEST

START_TEST(nothing_goes_to_a_device_that_is_slower_or_fails)
{
    qcPlanItem parts[2] = {Part(1000000, 0.0, 1.0), Part(600, 2.0, 1.0)};
    Choose(&s_deviceIsSlow, parts, 2);
    ck_assert(!parts[0].onDevice && !parts[1].onDevice);
    Choose(&s_deviceFails, parts, 2);
    ck_assert(!parts[0].onDevice && !parts[1].onDevice);
}
END_TEST

START_TEST(a_part_too_small_for_the_common_image_stays_with_the_sweep)
{
    // 1e-6 of the image is a thirtieth of a level, for 5000 triangles.
    qcPlanItem parts[2] = {Part(100000, 0.0, 1000.0), Part(5000, 500.0, 0.001)};
    Choose(&s_deviceIsQuick, parts, 2);
    ck_assert(parts[0].onDevice);
    ck_assert(!parts[1].onDevice);
}
END_TEST

START_TEST(parts_without_extent_stay_with_the_sweep)
{
    qcPlanItem part = Part(100000, 3.0, 0.0);
    Choose(&s_deviceIsQuick, &part, 1);
    ck_assert(!part.onDevice);
}
END_TEST

START_TEST(a_method_that_is_slower_than_calibrated_costs_no_more_than_a_trial)
{
    // The sweep takes 0.6 ms here, and layers 2.7, which calibration has the other way round.
    const qcPlanCosts actual = {0.00003, 0.0, 0.000135}, mirrored = {0.000135, 0.0, 0.00003};
    for (int quickest = 0; quickest < 2; quickest++)
    {
        const qcPlanCosts* costs = quickest == 0 ? &actual : &mirrored;
        const qcPlanCosts* calibrated = quickest == 0 ? &mirrored : &actual;
        qcPlanHistory history = {.queries = 0};
        RunQueries(&history, calibrated, costs, 30);
        double ms = RunQueries(&history, calibrated, costs, 10000);
        ck_assert_double_le(ms, 1.1 * 10000 * 0.6);
    }
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

START_TEST(a_scene_that_changes_is_answered_by_the_other_method_after_its_next_trial)
{
    qcPlanHistory history = {.queries = 0};
    const qcPlanCosts before = {0.00005, 0.0, 0.0001}, after = {0.0004, 0.0, 0.0001};
    RunQueries(&history, &s_deviceIsQuick, &before, 1000);
    ck_assert(!history.onDevice);
    RunQueries(&history, &s_deviceIsQuick, &after, 2 * qc_lastTrialGap);
    ck_assert(history.onDevice);
}
END_TEST

QC_RUN_TESTS("plan", a_method_that_is_slower_than_calibrated_costs_no_more_than_a_trial,
             a_sweep_that_would_take_many_times_as_long_is_never_tried,
             a_scene_that_changes_is_answered_by_the_other_method_after_its_next_trial,
             auto_is_the_sweep_without_compute_shaders, auto_looks_at_parts_where_there_are_compute_shaders,
             layers_without_compute_shaders_fall_back_and_say_so, few_triangles_are_not_worth_a_device,
             parts_go_to_the_device_when_that_saves_more_than_the_trip,
             nothing_goes_to_a_device_that_is_slower_or_fails,
             a_part_too_small_for_the_common_image_stays_with_the_sweep, parts_without_extent_stay_with_the_sweep)
