// `auto` on a device that is slow, or becomes slow: the CPU has nearly all of its steps.
#define _DEFAULT_SOURCE // usleep
#include "gl/replaced_driver.h"
#include "support/suite.h"

#include <unistd.h>

static useconds_t s_delay; // of each start of a kernel

static void APIENTRY DispatchSlowly(GLuint x, GLuint y, GLuint z)
{
    if (s_delay != 0)
        usleep(s_delay);
    s_real.DispatchCompute(x, y, z);
}

static void MakeSlow(struct qcGlFunctions* gl)
{
    gl->DispatchCompute = DispatchSlowly;
}

/// A cloth whose steps by the sweep take less than a millisecond.
static qcSoup MakeCloth(void)
{
    return qcSoup_MakeFoldedCloth(2, 24, 0.02, 0.02);
}

static qcBodyDef BodyDefOf(const qcSoup* cloth)
{
    qcBodyDef body = qcBodyDefOf(cloth);
    body.deforming = true;
    return body;
}

/// Ten steps of the sweep, which a sanitizer slows down.
static useconds_t FindDelay(void)
{
    enum
    {
        minDelay = 5000, // microseconds
        steps = 20
    };
    qcSoup soup = MakeCloth();
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef body = BodyDefOf(&soup);
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &body, &id));
    qcDetectDef def = qcDefaultDetectDef();
    def.threads = 1;
    double sweepMs = 0.0;
    for (int step = 0; step < steps; step++)
    {
        const qcResult* result;
        soup.positions[2] += 0.0001;
        CHECK_OK(qcScene_SetVertices(scene, id, soup.positions, qc_positionF64, 0));
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        sweepMs += result->profile.totalMs / steps;
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
    const double delay = 10.0 * 1000.0 * sweepMs;
    return delay > minDelay ? (useconds_t)delay : minDelay;
}

/// Steps of `auto` on new positions of a cloth; returns how many of them used the device, and checks the pairs of each.
static int CountStepsOnDevice(qcDevice* device, uint32_t threads, int steps)
{
    qcSoup soup = MakeCloth();
    qcScene *scene = qcMakeScene(device), *reference = qcMakeScene(NULL);
    qcBodyDef body = BodyDefOf(&soup);
    qcBodyId ids[2];
    CHECK_OK(qcScene_AddBody(scene, &body, &ids[0]));
    CHECK_OK(qcScene_AddBody(reference, &body, &ids[1]));
    qcDetectDef def = qcDefaultDetectDef();
    def.threads = threads;
    int onDevice = 0;
    for (int step = 0; step < steps; step++)
    {
        const qcResult* result;
        soup.positions[2] += 0.0001;
        CHECK_OK(qcScene_SetVertices(scene, ids[0], soup.positions, qc_positionF64, 0));
        CHECK_OK(qcScene_SetVertices(reference, ids[1], soup.positions, qc_positionF64, 0));
        qcPairList expected = qcDetectPairs(reference, &def);
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        qcPairList found = qcListOf(result);
        qcCheckSamePairs(&expected, &found, "auto");
        free(expected.pairs);
        onDevice += result->profile.partsOnDevice != 0;
    }
    qcScene_Destroy(scene);
    qcScene_Destroy(reference);
    qcSoup_Free(&soup);
    return onDevice;
}

START_TEST(a_slow_device_gets_no_step_of_auto)
{
    QC_FOR_EACH_DEVICE(device)
    {
        if (!MakeDriver(device, MakeSlow))
            continue;
        s_delay = FindDelay();
        for (uint32_t threads = 1; threads <= 2; threads++)
            ck_assert_int_eq(CountStepsOnDevice(device, threads, 400), 0);
    }
}
END_TEST

START_TEST(a_device_slower_than_calibrated_is_left_after_a_few_steps)
{
    // The costs of a GPU that was fast when it was measured.
    const qcPlanCosts costs = {.sweepPerTriangle = 0.001, .layersFixed = 0.01, .layersPerTriangle = 0.00001};
    QC_FOR_EACH_DEVICE(device)
    {
        if (!MakeDriver(device, MakeSlow))
            continue;
        s_delay = FindDelay();
        for (uint32_t threads = 1; threads <= 2; threads++)
        {
            qcDevice_KeepCosts(device, threads, &costs);
            int onDevice = CountStepsOnDevice(device, threads, 400);
            ck_assert_int_gt(onDevice, 0);
            ck_assert_int_le(onDevice, 40);
        }
    }
}
END_TEST

QC_RUN_TESTS("slow drivers", a_slow_device_gets_no_step_of_auto,
             a_device_slower_than_calibrated_is_left_after_a_few_steps)
