// Timers of a job against a fake GL that counts calls and whose clock advances with each call.
#include "gl/timers.h"
#include "base/clock.h"
#include "support/suite.h"

#include <string.h>

enum
{
    part_begin,
    part_kernel,
    part_readback,
    part_end,
    part_never,
    fake_maxQueries = 2 * qc_maxTimestamps
};

static struct
{
    GLint bits;
    uint64_t clock;
    uint64_t times[fake_maxQueries + 1]; ///< by query; 0: not issued, or not reached by the GPU when read
    uint32_t issued, passed;             ///< timestamps issued, and those before the thread's last wait
    uint32_t order[fake_maxQueries + 1]; ///< by query: index in the order of issue
    uint32_t calls, stalls;
} s_fake;

static void GetQueryiv(GLenum target, GLenum name, GLint* value)
{
    s_fake.calls++;
    ck_assert_uint_eq(target, GL_TIMESTAMP);
    ck_assert_uint_eq(name, GL_QUERY_COUNTER_BITS);
    *value = s_fake.bits;
}

static void GenQueries(GLsizei count, GLuint* queries)
{
    static GLuint s_next = 1;
    s_fake.calls++;
    for (GLsizei i = 0; i < count; i++)
        queries[i] = s_next++ % fake_maxQueries + 1;
}

static void DeleteQueries(GLsizei count, const GLuint* queries)
{
    (void)count;
    (void)queries;
    s_fake.calls++;
}

static void QueryCounter(GLuint query, GLenum target)
{
    s_fake.calls++;
    ck_assert_uint_eq(target, GL_TIMESTAMP);
    s_fake.clock += 1000000;
    s_fake.times[query] = s_fake.clock;
    s_fake.order[query] = ++s_fake.issued;
}

static void GetQueryObjectui64v(GLuint query, GLenum name, GLuint64* value)
{
    s_fake.calls++;
    ck_assert_uint_eq(name, GL_QUERY_RESULT);
    ck_assert_msg(s_fake.times[query] != 0, "a timestamp is read that was never issued");
    s_fake.stalls += s_fake.order[query] > s_fake.passed;
    *value = s_fake.times[query];
}

static void Flush(void)
{
    s_fake.calls++;
}

static struct qcGlFunctions MakeGl(GLint bits)
{
    memset(&s_fake, 0, sizeof s_fake);
    s_fake.bits = bits;
    return (struct qcGlFunctions){.GetQueryiv = GetQueryiv,
                                  .GenQueries = GenQueries,
                                  .DeleteQueries = DeleteQueries,
                                  .QueryCounter = QueryCounter,
                                  .GetQueryObjectui64v = GetQueryObjectui64v,
                                  .Flush = Flush};
}

/// Kernels, a wait for the device, results read back.
static void RunJob(const struct qcGlFunctions* gl, qcGlTimers* timers, bool on, int kernels)
{
    qcGlTimers_Begin(gl, timers, on, qcClock_Now(), part_begin);
    for (int i = 0; i < kernels; i++)
        qcGlTimers_Mark(gl, timers, part_kernel);
    s_fake.passed = s_fake.issued;
    qcGlTimers_MarkPassed(timers);
    qcGlTimers_Mark(gl, timers, part_readback);
    qcGlTimers_End(gl, timers, part_end);
}

START_TEST(timers_that_are_off_make_no_gl_call)
{
    struct qcGlFunctions gl = MakeGl(64);
    qcGlTimers timers = {.on = false};
    RunJob(&gl, &timers, false, 3);
    qcGlTimers_Delete(&gl, &timers);
    ck_assert_uint_eq(s_fake.calls, 0);
}
END_TEST

START_TEST(a_part_has_the_sum_of_its_intervals)
{
    struct qcGlFunctions gl = MakeGl(64);
    qcGlTimers timers = {.on = false};
    RunJob(&gl, &timers, true, 3);
    ck_assert_double_eq_tol(timers.deviceMs[part_kernel], 3.0, 1e-9);
    ck_assert(timers.threadMs[part_begin] >= 0.0 && timers.threadMs[part_kernel] >= 0.0);
    ck_assert(timers.threadMs[part_never] < 0.0 && timers.deviceMs[part_never] < 0.0);
    qcGlTimers_Delete(&gl, &timers);
}
END_TEST

START_TEST(no_job_waits_for_its_own_last_timestamps)
{
    struct qcGlFunctions gl = MakeGl(64);
    qcGlTimers timers = {.on = false};
    RunJob(&gl, &timers, true, 2);
    ck_assert_msg(timers.deviceMs[part_readback] < 0.0, "of a first job it can't be known yet");
    for (int job = 0; job < 5; job++)
    {
        RunJob(&gl, &timers, true, 2);
        ck_assert_double_eq_tol(timers.deviceMs[part_kernel], 2.0, 1e-9);
        ck_assert_double_eq_tol(timers.deviceMs[part_readback], 1.0, 1e-9);
        // Jobs without timers between them change nothing.
        RunJob(&gl, &timers, false, 2);
    }
    ck_assert_uint_eq(s_fake.stalls, 0);
    qcGlTimers_Delete(&gl, &timers);
}
END_TEST

START_TEST(a_device_without_timestamps_has_thread_times_only)
{
    struct qcGlFunctions gl = MakeGl(0);
    qcGlTimers timers = {.on = false};
    for (int job = 0; job < 3; job++)
        RunJob(&gl, &timers, true, 2);
    ck_assert_uint_eq(s_fake.issued, 0);
    for (int part = 0; part < qc_maxTimedParts; part++)
        ck_assert(timers.deviceMs[part] < 0.0);
    ck_assert(timers.threadMs[part_kernel] >= 0.0);
    qcGlTimers_Delete(&gl, &timers);
}
END_TEST

START_TEST(a_job_with_more_marks_than_timestamps_has_thread_times_only)
{
    struct qcGlFunctions gl = MakeGl(64);
    qcGlTimers timers = {.on = false};
    RunJob(&gl, &timers, true, 2 * qc_maxTimestamps);
    ck_assert_uint_eq(s_fake.issued, qc_maxTimestamps);
    ck_assert(timers.deviceMs[part_kernel] < 0.0 && timers.threadMs[part_kernel] >= 0.0);
    // The next job is complete again.
    RunJob(&gl, &timers, true, 2);
    ck_assert_double_eq_tol(timers.deviceMs[part_kernel], 2.0, 1e-9);
    qcGlTimers_Delete(&gl, &timers);
}
END_TEST

QC_RUN_TESTS("GL timers", timers_that_are_off_make_no_gl_call, a_part_has_the_sum_of_its_intervals,
             no_job_waits_for_its_own_last_timestamps, a_device_without_timestamps_has_thread_times_only,
             a_job_with_more_marks_than_timestamps_has_thread_times_only)
