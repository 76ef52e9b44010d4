// A scene that lives long: bodies are added, removed, moved, bent and switched in each step. At times its result is
// compared with that of a new scene, and at times it is emptied: memory stays where it was after a tenth of the run.
// QC_TEST_LONG: a million steps instead of some ten thousand.
#include "long/changing_world.h"
#include "long/memory_use.h"
#include "support/long_form.h"
#include "support/suite.h"

#include <stdio.h>

enum
{
    qc_shortSteps = 20000,
    qc_longSteps = 1000000,
    qc_periods = 20
};

START_TEST(a_scene_of_a_million_steps_has_the_results_of_a_new_one_in_the_same_memory)
{
    const int steps = qcIsLongForm() ? qc_longSteps : qc_shortSteps, period = steps / qc_periods;
    qcWorld world;
    qcWorld_Create(&world, 1, NULL);
    qcMemoryUse memory = {0};
    uint64_t compared = 0, found = 0;
    for (int step = 0; step < steps; step++)
    {
        qcWorld_Change(&world);
        qcDetectDef def = qcWorld_MakeDef(&world);
        if (qcRandom_Below(&world.random, 100) == 0)
        {
            char where[32];
            snprintf(where, sizeof where, "step %d", step);
            found += qcWorld_Compare(&world, &def, where);
            qcWorld_CheckRemoved(&world);
            compared++;
        }
        else
        {
            const qcResult* result;
            CHECK_OK(qcScene_Detect(world.scene, &def, &result));
        }
        if (step % period == period - 1)
        {
            qcWorld_Clear(&world);
            qcMemoryUse_Add(&memory);
        }
    }
    printf(
        "%d steps, %llu changes, %llu compared with new scenes: %llu pairs and contacts; %zu bytes, resident %ld KB\n",
        steps, (unsigned long long)world.changes, (unsigned long long)compared, (unsigned long long)found,
        memory.bytes[memory.count - 1], memory.residentKb[memory.count - 1]);
    qcMemoryUse_Check(&memory);
    ck_assert_uint_gt(found, 10 * compared);
    qcWorld_Destroy(&world);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS("changing world", a_scene_of_a_million_steps_has_the_results_of_a_new_one_in_the_same_memory)
