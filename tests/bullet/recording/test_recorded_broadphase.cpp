// A recorded qcBroadphase replays with the pairs and boxes that it found, by another one and by brute force.
// Standard headers first: check defines a macro named fail.
#include <cstdlib>
#include <cstring>
#include <thread>

#include "bullet/broadphase/broadphase_moves.h"

#include "support/run_program.h"

namespace
{
struct SaltedFilter : btOverlapFilterCallback
{
    int salt = 0;

    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override
    {
        return (a->m_uniqueId * 7 + b->m_uniqueId + salt) % 3 != 0;
    }
};

struct CountingQuery : btBroadphaseAabbCallback
{
    size_t count = 0;

    bool process(const btBroadphaseProxy*) override
    {
        count++;
        return true;
    }
};

/// Shortens the rest of the cast after some boxes.
struct ShorteningCast : btBroadphaseRayCallback
{
    size_t count = 0;

    bool process(const btBroadphaseProxy*) override
    {
        if (++count % 3 == 0)
            m_lambda_max *= btScalar(0.75);
        return true;
    }
};

void CastRay(qcBroadphaseModel& model, qcRandom* random)
{
    btVector3 from = qcRandomPoint(random, 7), to = qcRandomPoint(random, 7), size = qcRandomPoint(random, 1);
    ShorteningCast callback;
    btVector3 direction = (to - from).normalized();
    for (int k = 0; k < 3; k++)
    {
        callback.m_rayDirectionInverse[k] = direction[k] == 0 ? BT_LARGE_FLOAT : 1 / direction[k];
        callback.m_signs[k] = callback.m_rayDirectionInverse[k] < 0;
    }
    callback.m_lambda_max = direction.dot(to - from);
    if (qcRandom_Below(random, 2) == 0)
        model.broadphase.rayTest(from, to, callback);
    else
        model.broadphase.rayTest(from, to, callback, -size, size);
}

/// Boxes come, move, change their filters and go, between searches and queries.
void Step(qcBroadphaseModel& model, qcRandom* random, const qcBoxKinds& kinds, SaltedFilter* filter)
{
    for (uint32_t i = 1 + qcRandom_Below(random, 6); i > 0; i--)
    {
        btVector3 aabbMin, aabbMax;
        qcRandomBounds(random, kinds, &aabbMin, &aabbMax);
        if (model.proxies.size() < 40)
            model.Create(aabbMin, aabbMax, 1 << qcRandom_Below(random, 3), int(qcRandom_Below(random, 8)));
        else if (qcRandom_Below(random, 4) == 0)
            model.Destroy(qcRandom_Below(random, uint32_t(model.proxies.size())));
    }
    for (uint32_t i = 0; i < 12; i++)
    {
        size_t k = qcRandom_Below(random, uint32_t(model.proxies.size()));
        if (qcRandom_Below(random, 4) == 0)
            model.proxies[k].proxy->m_collisionFilterMask = int(qcRandom_Below(random, 8));
        qcMoveOne(model, random, kinds, k);
    }
    if (qcRandom_Below(random, 3) == 0)
        model.proxies[qcRandom_Below(random, uint32_t(model.proxies.size()))].proxy->m_collisionFilterMask = 1;
    uint32_t choice = qcRandom_Below(random, 5);
    filter->salt = int(choice);
    model.cache->setOverlapFilterCallback(choice < 2 ? filter : nullptr);
    model.broadphase.calculateOverlappingPairs(&model.dispatcher);
    CastRay(model, random);
    CountingQuery query;
    btVector3 corner = qcRandomPoint(random, 7);
    model.broadphase.aabbTest(corner, corner + btVector3(1, 2, 3), query);
}

void Record(uint64_t start, const qcBoxKinds& kinds, int unrecorded)
{
    qcRandom random = {start};
    SaltedFilter filter;
    qcBroadphaseModel model;
    for (int i = 0; i < unrecorded; i++)
        Step(model, &random, kinds, &filter);
    ck_assert_int_eq(model.broadphase.record("a.qcr"), qc_statusOk);
    for (int i = 0; i < 20; i++)
        Step(model, &random, kinds, &filter);
    ck_assert_int_eq(model.broadphase.record(nullptr), qc_statusOk);
    model.cache->setOverlapFilterCallback(nullptr);
}

/// 60 results: 20 searches for pairs, 20 casts, 20 queries of boxes.
void CheckReplay(const char* method, const char* results)
{
    int status = Run(QC_REPLAY_PROGRAM " --method %s a.qcr", method);
    ck_assert_msg(status == 0, "%s%s", GetOutput(), GetErrors());
    ck_assert_msg(std::strstr(GetOutput(), results) != nullptr, "%s", GetOutput());
}
} // namespace

START_TEST(a_recording_from_the_start_replays_to_the_last_box)
{
    EnterFolder();
    for (uint64_t start = 1; start <= 12; start++)
    {
        Record(start, {start % 2 == 0, start % 3 == 0}, 0);
        CheckReplay("recorded", "\n60 results are the recorded ones, 0 differ");
        CheckReplay("brute", "\n60 results are the recorded ones, 0 differ");
    }
    LeaveFolder();
}
END_TEST

START_TEST(a_recording_that_starts_late_begins_with_the_present_boxes)
{
    EnterFolder();
    for (uint64_t start = 21; start <= 26; start++)
    {
        Record(start, {false, start % 2 == 0}, 8);
        CheckReplay("recorded", " 0 differ");
        CheckReplay("brute", "\n60 results are the recorded ones, 0 differ");
    }
    LeaveFolder();
}
END_TEST

START_TEST(a_broadphase_that_is_reset_in_between_replays)
{
    EnterFolder();
    qcRandom random = {5};
    SaltedFilter filter;
    qcBroadphaseModel model;
    ck_assert_int_eq(model.broadphase.record("a.qcr"), qc_statusOk);
    for (int i = 0; i < 20; i++)
    {
        Step(model, &random, {}, &filter);
        if (i % 7 != 6)
            continue;
        while (!model.proxies.empty())
            model.Destroy(model.proxies.size() - 1);
        model.broadphase.resetPool(&model.dispatcher);
    }
    ck_assert_int_eq(model.broadphase.record(nullptr), qc_statusOk);
    model.cache->setOverlapFilterCallback(nullptr);
    CheckReplay("recorded", "\n60 results are the recorded ones, 0 differ");
    CheckReplay("brute", "\n60 results are the recorded ones, 0 differ");
    LeaveFolder();
}
END_TEST

START_TEST(a_broadphase_goes_on_where_its_recording_cannot)
{
    qcBroadphaseModel model;
    qcRandom random = {3};
    SaltedFilter filter;
    ck_assert_int_eq(model.broadphase.record("/no/such/folder/a.qcr"), qc_statusFile);
    ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "/no/such/folder/a.qcr can't be created"));
    model.broadphase.record("/dev/full");
    for (int i = 0; i < 10; i++)
        Step(model, &random, {}, &filter);
    ck_assert_int_eq(model.broadphase.record(nullptr), qc_statusFile);
    model.cache->setOverlapFilterCallback(nullptr);
    ck_assert_uint_gt(model.Check(), 0);
}
END_TEST

START_TEST(queries_on_several_threads_are_all_recorded)
{
    EnterFolder();
    {
        qcBroadphaseModel model;
        qcRandom random = {9};
        SaltedFilter filter;
        ck_assert_int_eq(model.broadphase.record("a.qcr"), qc_statusOk);
        for (int i = 0; i < 10; i++)
            Step(model, &random, {}, &filter);
        model.cache->setOverlapFilterCallback(nullptr);
        std::vector<std::thread> threads;
        for (uint64_t t = 0; t < 4; t++)
            threads.emplace_back(
                [&model, t]
                {
                    qcRandom own = {100 + t};
                    for (int i = 0; i < 50; i++)
                    {
                        CountingQuery query;
                        btVector3 corner = qcRandomPoint(&own, 7);
                        model.broadphase.aabbTest(corner, corner + btVector3(2, 2, 2), query);
                        CastRay(model, &own);
                    }
                });
        for (std::thread& thread : threads)
            thread.join();
    }
    // 10 steps of three results, and 4 * 50 * 2 queries.
    CheckReplay("recorded", "\n430 results are the recorded ones, 0 differ");
    LeaveFolder();
}
END_TEST

START_TEST(the_other_precision_is_refused_with_the_programs_name)
{
    EnterFolder();
    Record(1, {}, 0);
    ck_assert_int_eq(Run(QC_OTHER_REPLAY_PROGRAM " a.qcr"), 3);
    ck_assert_ptr_nonnull(std::strstr(GetErrors(), sizeof(btScalar) == 4
                                                       ? "no broadphase of single precision; use qc-replay,"
                                                       : "use qc-replay-double"));
    ck_assert_int_eq(Run(QC_OTHER_REPLAY_PROGRAM " --method brute a.qcr"), 0);
    ck_assert_int_eq(Run(QC_REPLAY_PROGRAM " --method sweep a.qcr"), 2);
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("recorded_broadphase", a_recording_from_the_start_replays_to_the_last_box,
             a_recording_that_starts_late_begins_with_the_present_boxes, a_broadphase_that_is_reset_in_between_replays,
             a_broadphase_goes_on_where_its_recording_cannot, queries_on_several_threads_are_all_recorded,
             the_other_precision_is_refused_with_the_programs_name)
