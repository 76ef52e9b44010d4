// A lost device is opened again by itself, less and less often if it fails; meanwhile the CPU answers.
#define _POSIX_C_SOURCE 200809L
#include "gl/reopening.h"
#include "gl/replaced_driver.h"
#include "support/suite.h"

#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

enum
{
    qc_maxWaits = 3000 ///< of 10 ms
};

static void Rest(void)
{
    const struct timespec pause = {0, 10000000};
    nanosleep(&pause, NULL);
}

/// A device of this kind that is opened again after `seconds`; null: it does not work here, or has no compute shaders.
static qcDevice* Open(qcDeviceKind kind, double seconds)
{
    qcDevice* device = qcOpenOrSkip(kind);
    qcDeviceInfo info = {.compute = false};
    if (device != NULL)
        qcDevice_GetInfo(device, &info);
    qcDevice_Destroy(device);
    if (!info.compute)
        return NULL;
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = kind;
    def.reopenSeconds = seconds;
    CHECK_OK(qcDevice_Create(&def, &device));
    return device;
}

static GLenum APIENTRY ReportReset(void)
{
    return GL_INNOCENT_CONTEXT_RESET;
}

static void MakeLost(struct qcGlFunctions* gl)
{
    gl->GetGraphicsResetStatus = ReportReset;
}

static void Lose(qcDevice* device)
{
    Replacement replacement = {MakeLost};
    ck_assert_int_eq(qcDevice_Run(device, Replace, &replacement, "a test"), qc_statusDeviceLost);
}

static bool IsLost(const qcDevice* device)
{
    qcDeviceInfo info;
    CHECK_OK(qcDevice_GetInfo(device, &info));
    return info.lost;
}

START_TEST(a_lost_device_is_opened_again_while_the_cpu_answers)
{
    for (int kind = 0; kind < qc_testDeviceCount; kind++)
    {
        qcDevice* device = Open(qc_testKinds[kind], 0.02);
        if (device == NULL)
            continue;
        qcDeviceInfo before, after;
        CHECK_OK(qcDevice_GetInfo(device, &before));
        World worlds[2] = {MakeWorld(device), MakeWorld(device)};
        for (uint32_t loss = 1; loss <= 3; loss++)
        {
            for (int i = 0; i < 2; i++)
            {
                MoveAll(&worlds[i]);
                CheckAnswered(CheckPairs(worlds[i].scene, 0.0));
            }
            Lose(device);
            ck_assert(IsLost(device));
            // Every step finds all pairs, whoever answers. In reverse order: names in the new context belong to other
            // objects than before.
            int waits = 0;
            for (const char* fallback = ""; fallback != NULL; waits++)
            {
                MoveAll(&worlds[1]);
                fallback = CheckPairs(worlds[1].scene, 0.0);
                if (fallback != NULL)
                    CheckReason(fallback, "the GL context is lost");
                ck_assert_int_lt(waits, qc_maxWaits);
                Rest();
            }
            ck_assert_int_gt(waits, 1);
            ck_assert(!IsLost(device));
            ck_assert_uint_eq(qcDevice_GetGeneration(device), loss + 1);
            // A job with objects of the lost context does not run in the new one.
            Replacement replacement = {MakeLost};
            ck_assert_int_eq(qcDevice_RunIn(device, loss, Replace, &replacement, "a test"), qc_statusDeviceLost);
            ck_assert(!IsLost(device));
        }
        CHECK_OK(qcDevice_GetInfo(device, &after));
        ck_assert_ptr_eq(before.renderer, after.renderer);
        qcScene_Destroy(worlds[0].scene);
        qcScene_Destroy(worlds[1].scene);
        qcDevice_Destroy(device);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_device_that_nobody_uses_is_not_opened_again)
{
    for (int kind = 0; kind < qc_testDeviceCount; kind++)
    {
        qcDevice* device = Open(qc_testKinds[kind], 0.001);
        if (device == NULL)
            continue;
        Lose(device);
        for (int i = 0; i < 10; i++)
            Rest();
        ck_assert(IsLost(device));
        ck_assert_uint_eq(qcDevice_GetGeneration(device), 1);
        qcDevice_Destroy(device);
    }
}
END_TEST

START_TEST(below_0_only_the_caller_opens_the_device_again)
{
    for (int kind = 0; kind < qc_testDeviceCount; kind++)
    {
        qcDevice* device = Open(qc_testKinds[kind], -1.0);
        if (device == NULL)
            continue;
        World world = MakeWorld(device);
        Lose(device);
        for (int i = 0; i < 10; i++)
        {
            MoveAll(&world);
            CheckReason(CheckPairs(world.scene, 0.0), "the GL context is lost");
            Rest();
        }
        ck_assert(IsLost(device));
        CHECK_OK(qcDevice_Reopen(device));
        MoveAll(&world);
        CheckAnswered(CheckPairs(world.scene, 0.0));
        qcScene_Destroy(world.scene);
        qcDevice_Destroy(device);
    }
}
END_TEST

START_TEST(a_device_that_does_not_open_is_tried_until_it_does)
{
    unsetenv("GALLIUM_DRIVER");
    qcDevice* device = Open(qc_deviceOsmesa, 0.005);
    if (device == NULL)
        return;
    World world = MakeWorld(device);
    setenv("GALLIUM_DRIVER", "none", 1);
    Lose(device);
    for (int i = 0; i < 30; i++)
    {
        MoveAll(&world);
        CheckReason(CheckPairs(world.scene, 0.0), "the GL context is lost");
        Rest();
    }
    ck_assert_uint_eq(qcDevice_GetGeneration(device), 1);
    // Without calls there are no attempts, which read the environment.
    for (int i = 0; i < 20; i++)
        Rest();
    unsetenv("GALLIUM_DRIVER");
    int waits = 0;
    for (const char* fallback = ""; fallback != NULL; waits++)
    {
        MoveAll(&world);
        fallback = CheckPairs(world.scene, 0.0);
        ck_assert_int_lt(waits, qc_maxWaits);
        Rest();
    }
    qcScene_Destroy(world.scene);
    qcDevice_Destroy(device);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

typedef struct Caller
{
    World world;
    atomic_bool* stop;
    uint32_t onDevice, onCpu;
} Caller;

static void* StepOn(void* context)
{
    Caller* caller = context;
    while (!atomic_load(caller->stop))
    {
        MoveAll(&caller->world);
        if (CheckPairs(caller->world.scene, 0.0) == NULL)
            caller->onDevice++;
        else
            caller->onCpu++;
    }
    return NULL;
}

START_TEST(scenes_on_several_threads_find_all_pairs_while_their_device_comes_and_goes)
{
    for (int kind = 0; kind < qc_testDeviceCount; kind++)
    {
        qcDevice* device = Open(qc_testKinds[kind], 0.001);
        if (device == NULL)
            continue;
        atomic_bool stop = false;
        Caller callers[3];
        pthread_t threads[3];
        for (int i = 0; i < 3; i++)
        {
            callers[i] = (Caller){.world = MakeWorld(device), .stop = &stop};
            ck_assert_int_eq(pthread_create(&threads[i], NULL, StepOn, &callers[i]), 0);
        }
        for (int loss = 0; loss < 8; loss++)
        {
            for (int i = 0; i < 5; i++)
                Rest();
            Replacement replacement = {MakeLost};
            (void)qcDevice_Run(device, Replace, &replacement, "a test");
        }
        atomic_store(&stop, true);
        uint32_t onCpu = 0;
        for (int i = 0; i < 3; i++)
        {
            pthread_join(threads[i], NULL);
            onCpu += callers[i].onCpu;
            qcScene_Destroy(callers[i].world.scene);
        }
        ck_assert_uint_gt(onCpu, 0);
        ck_assert_uint_gt(qcDevice_GetGeneration(device), 1);
        qcDevice_Destroy(device);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(pauses_double_up_to_a_limit_and_start_anew_after_a_healthy_time)
{
    qcReopening r = qcReopening_Begin(10.0, 0.0);
    double now = 1.0, pause = 10.0;
    for (int i = 0; i < 12; i++)
    {
        qcReopening_Fail(&r, now);
        ck_assert(!qcReopening_IsDue(&r, now + 0.99 * pause));
        now += pause;
        ck_assert(qcReopening_IsDue(&r, now));
        pause = pause < 640.0 ? 2.0 * pause : 640.0;
    }
    // Lost again soon after it was opened.
    qcReopening_Succeed(&r, now);
    qcReopening_Fail(&r, now + 1.0);
    ck_assert(!qcReopening_IsDue(&r, now + 600.0));
    ck_assert(qcReopening_IsDue(&r, now + 641.0));
    // Lost after a healthy time.
    qcReopening_Succeed(&r, now + 641.0);
    now += 641.0 + 641.0;
    qcReopening_Fail(&r, now);
    ck_assert(!qcReopening_IsDue(&r, now + 9.0));
    ck_assert(qcReopening_IsDue(&r, now + 10.0));
    qcReopening never = qcReopening_Begin(-1.0, 0.0);
    qcReopening_Fail(&never, 1.0);
    ck_assert(!qcReopening_IsDue(&never, 1e12));
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("reopening", a_lost_device_is_opened_again_while_the_cpu_answers,
                        a_device_that_nobody_uses_is_not_opened_again, below_0_only_the_caller_opens_the_device_again,
                        a_device_that_does_not_open_is_tried_until_it_does,
                        scenes_on_several_threads_find_all_pairs_while_their_device_comes_and_goes,
                        pauses_double_up_to_a_limit_and_start_anew_after_a_healthy_time)
