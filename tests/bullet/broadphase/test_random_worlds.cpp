// Random worlds on qcBroadphase: in each step the pairs that brute force finds, the hits of btDbvtBroadphase, and the
// equal results in two runs. The environment's QC_TEST_WORLDS sets their number (CK_TIMEOUT_MULTIPLIER, the time).
#include "bullet/broadphase/random_worlds.h"
#include "bullet/broadphase/watched_broadphase.h"

#include <cstdlib>

namespace
{
constexpr int qc_steps = 300;

int CountWorlds(int least)
{
    const char* text = getenv("QC_TEST_WORLDS");
    return std::max(least, text != nullptr ? atoi(text) : 0);
}

/// Half of them are the common kind.
qcWorldKind KindOf(int seed)
{
    return seed % 2 == 0 ? qcWorldKind::discrete : qcWorldKind(seed / 2 % qc_worldKindCount);
}

struct SeedRun
{
    std::vector<uint64_t> steps; ///< hashes of all transforms and velocities
    uint64_t order = 0;          ///< hash of all pairs, in their order
    size_t pairs = 0, hits = 0;
};

SeedRun RunSeed(int seed)
{
    auto* broadphase = new qcWatchedBroadphase;
    qcRandomWorld world(uint64_t(seed), KindOf(seed), broadphase);
    SeedRun life;
    for (int step = 0; step < qc_steps; step++)
    {
        world.Change();
        const size_t before = broadphase->comparisons;
        world.Step();
        CHECK_QUICKLY(broadphase->comparisons > before);
        life.steps.push_back(world.Hash());
        if (step % 6 == 5)
            life.hits += world.CompareQueries();
    }
    life.order = broadphase->order;
    life.pairs = broadphase->pairs;
    return life;
}
} // namespace

START_TEST(random_worlds_hold_the_pairs_of_brute_force_hit_as_on_btDbvtBroadphase_and_run_twice_alike)
{
    const int worlds = CountWorlds(12);
    size_t pairs = 0, hits = 0;
    uint64_t motion = 0;
    for (int number = 1; number <= worlds; number++)
    {
        const SeedRun first = RunSeed(number), second = RunSeed(number);
        for (size_t step = 0; step < qc_steps; step++)
            if (first.steps[step] != second.steps[step])
                ck_abort_msg("world %d (%s) moves differently in step %d", number,
                             qcWorldKindNames[int(KindOf(number))], int(step));
        CHECK_QUICKLY(first.order == second.order);
        for (uint64_t step : first.steps)
            motion = motion * 0x100000001b3ULL ^ step;
        pairs += first.pairs;
        hits += first.hits;
    }
    ck_assert_uint_gt(pairs, size_t(worlds) * qc_steps * 20);
    ck_assert_uint_gt(hits, size_t(worlds) * 50);
    printf("%d worlds of %d steps: %zu pairs, %zu hits of rays and sweeps, hash of all motion %016llx\n", worlds,
           qc_steps, pairs, hits, (unsigned long long)motion);
}
END_TEST

QC_RUN_TESTS("broadphase in random worlds",
             random_worlds_hold_the_pairs_of_brute_force_hit_as_on_btDbvtBroadphase_and_run_twice_alike)
