// qc-gl-cloth as a user runs it: no position is uploaded, and the pairs are the CPU's in the same positions.
#include "support/devices.h"
#include "support/run_program.h"
#include "support/sanitizers.h"
#include "support/suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CLOTH QC_CLOTH_PROGRAM

/// Exit status 4: no context of GL 4.5 opens here. It is an error where QC_TEST_DEVICES requires the device.
static bool Opens(int status)
{
    const char* required = getenv("QC_TEST_DEVICES");
    if (status != 4)
        return true;
    ck_assert_msg(required == NULL || strstr(required, qcIsZinkProcess() ? "zink" : "surfaceless") == NULL, "%s",
                  GetErrors());
    printf("skipped: %s", GetErrors());
    return false;
}

START_TEST(positions_stay_on_the_device_and_the_pairs_are_the_cpus)
{
    EnterFolder();
    int status = Run(CLOTH " --side 60 --frames 45 --check --picture cloth.png");
    if (Opens(status))
    {
        ck_assert_msg(status == 0, "%s", GetErrors());
        ck_assert_ptr_nonnull(strstr(GetOutput(), "the CPU finds the same pairs in every frame\n"));
        uint32_t frames = 0, paired = 0;
        const char* line = GetOutput();
        for (; (line = strchr(line, '\n')) != NULL && line[1] != 0; line++)
        {
            unsigned frame, pairs, positions, uploaded, all, readBack;
            if (sscanf(line, "%u %u %u %u %u %u", &frame, &pairs, &positions, &uploaded, &all, &readBack) != 6)
                continue;
            ck_assert_uint_eq(frame, ++frames);
            ck_assert_uint_eq(positions, 12 * 60 * 60);
            ck_assert_uint_eq(uploaded, 0);
            ck_assert_uint_lt(readBack, positions / 4);
            ck_assert(frame == 1 || all < 4000 + 20 * pairs); // the first frame uploads the topology
            paired += pairs > 0;
        }
        ck_assert_uint_eq(frames, 45);
        ck_assert_uint_gt(paired, 5);
        ck_assert_ptr_null(strstr(GetOutput(), "on the CPU"));
        ck_assert_uint_eq(CountEntries(), 1);
    }
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_are_named)
{
    static const CommandMistake mistakes[] = {
        {"--sides 10", 2, "--sides"},  {"--side 2", 2, "--side"},
        {"--frames 0", 2, "--frames"}, {"--platform x11", 2, "x11"},
        {"cloth.obj", 2, "cloth.obj"}, {"--frames 1 --picture missing/cloth.png", 1, "missing"},
    };
    EnterFolder();
    CheckMistakes(CLOTH, mistakes, sizeof mistakes / sizeof mistakes[0]);
    ck_assert_int_eq(Run(CLOTH " --help"), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "--check"));
    ck_assert_uint_eq(CountEntries(), 0);
    LeaveFolder();
}
END_TEST

START_TEST(a_driver_that_does_not_exist_is_named)
{
    if (!qcCanUnloadDrivers())
        return;
    EnterFolder();
    // Mesa loses its table of options then, in a library that is gone when leaks are named.
    ck_assert_int_eq(Run("LSAN_OPTIONS=detect_leaks=0 GALLIUM_DRIVER=none MESA_LOADER_DRIVER_OVERRIDE=none "
                         "LIBGL_ALWAYS_SOFTWARE=1 " CLOTH " --frames 1"),
                     4);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "qc-gl-cloth: "));
    ck_assert_uint_eq(CountEntries(), 0);
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("gl cloth", positions_stay_on_the_device_and_the_pairs_are_the_cpus, mistakes_are_named,
             a_driver_that_does_not_exist_is_named)
