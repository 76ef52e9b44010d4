// qc-replay as a user runs it.
#include "support/replay.h"
#include "quickcullide/hash.h"
#include "support/devices.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <stdio.h>

#define REPLAY QC_REPLAY_PROGRAM

enum
{
    qc_detections = 4
};

/// A cloth that moves, in a.qcr; the pairs of its detections.
static void MakeRecording(size_t pairs[qc_detections])
{
    qcScene* scene = qcMakeScene(NULL);
    CHECK_OK(qcScene_Record(scene, "a.qcr"));
    qcSoup soup = qcSoup_MakeFoldedCloth(2, 16, 0.02, 0.03);
    qcBodyDef bodyDef = qcBodyDefOf(&soup);
    bodyDef.deforming = true;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &bodyDef, &id));
    qcRandom random = {1};
    for (int i = 0; i < qc_detections; i++)
    {
        for (size_t k = 0; k < 3 * (size_t)soup.vertexCount; k++)
            soup.positions[k] += qcRandom_Uniform(&random, -0.01, 0.01);
        CHECK_OK(qcScene_SetVertices(scene, id, soup.positions, qc_positionF64, 0));
        qcDetectDef def = qcDefaultDetectDef();
        def.margin = 0.01 * i;
        const qcResult* result;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        pairs[i] = result->pairCount;
        ck_assert_uint_gt(pairs[i], 0);
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
}

/// Changes the hash of the pairs of the second result, and the record's own hash.
static void ForgeResult(void)
{
    FILE* file = fopen("a.qcr", "r+b");
    ck_assert_ptr_nonnull(file);
    uint64_t head[2], words[64];
    long at = 24;
    for (uint64_t record = 0, results = 0;; record++)
    {
        fseek(file, at, SEEK_SET);
        ck_assert_uint_eq(fread(head, sizeof head, 1, file), 1);
        results += (uint32_t)head[0] == 65;
        if (results == 2)
        {
            ck_assert_uint_eq(head[1], 88);
            memcpy(words, head, sizeof head);
            ck_assert_uint_eq(fread(words + 2, 88, 1, file), 1);
            words[4] ^= 1;
            words[13] = qcXxh64(words, 104, record);
            fseek(file, at, SEEK_SET);
            ck_assert_uint_eq(fwrite(words, 112, 1, file), 1);
            break;
        }
        at += 24 + (long)head[1];
    }
    fclose(file);
}

START_TEST(a_recording_replays_equal_by_every_method_that_never_misses)
{
    EnterFolder();
    size_t pairs[qc_detections];
    MakeRecording(pairs);
    const char* options[] = {"",
                             "--method sweep --threads 1",
                             "--method brute --threads 2",
                             "--method auto --threads 0",
                             "--method layers",
                             "--method=layers --device none",
                             "--method recorded --device none"};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++)
    {
        ck_assert_msg(Run(REPLAY " %s a.qcr", options[i]) == 0, "%s: %s%s", options[i], GetOutput(), GetErrors());
        ck_assert_ptr_nonnull(strstr(GetOutput(), "4 results are the recorded ones, 0 differ"));
    }
    ck_assert_ptr_null(strstr(GetOutput(), "not compared"));
    ck_assert_ptr_null(strstr(GetOutput(), "without closing"));
    // The record of the end is 24 bytes long.
    ck_assert_int_eq(Run("head -c -24 a.qcr >b.qcr; " REPLAY " b.qcr"), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "the program that recorded ended without closing the file"));
    LeaveFolder();
}
END_TEST

START_TEST(a_result_that_differs_is_named_and_fails)
{
    EnterFolder();
    size_t pairs[qc_detections];
    MakeRecording(pairs);
    ForgeResult();
    ck_assert_int_eq(Run(REPLAY " a.qcr"), 1);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "DIFFERS in pairs"));
    ck_assert_ptr_null(strstr(GetOutput(), "DIFFERS in pairs,"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "3 results are the recorded ones, 1 differ"));
    ck_assert_ptr_nonnull(strstr(GetErrors(), "qc-replay: 1 of 4 results differ from the recorded ones"));
    ck_assert_int_eq(Run(REPLAY " --from 3 a.qcr"), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "2 results are the recorded ones, 0 differ"));
    ck_assert_int_eq(Run(REPLAY " --from 2 --to 2 a.qcr"), 1);
    ck_assert_int_eq(Run(REPLAY " --to 1 --csv a.csv a.qcr"), 0);
    char csv[1024], expected[64];
    ck_assert(ReadText("a.csv", csv, sizeof csv));
    ck_assert_ptr_nonnull(strstr(csv, "detection,operation,method,milliseconds,pairs,"));
    snprintf(expected, sizeof expected, ",%zu,0,0,%zu,0,\"same\"\n", pairs[0], pairs[0]);
    ck_assert_ptr_nonnull(strstr(csv, "\n1,2,sweep,"));
    ck_assert_ptr_nonnull(strstr(csv, expected));
    LeaveFolder();
}
END_TEST

START_TEST(pairs_that_a_sampling_method_misses_are_counted)
{
    qcDevice* device = qcOpenOrSkip(qc_deviceOsmesa);
    qcDevice_Destroy(device);
    if (device == NULL)
        return;
    EnterFolder();
    size_t pairs[qc_detections];
    MakeRecording(pairs);
    ck_assert_int_eq(Run(REPLAY " --method quick --device osmesa --to 1 --each a.qcr"), 0);
    char expected[64];
    // Without a margin, as the first detection was.
    snprintf(expected, sizeof expected, " of %zu pairs, in 1 detections by a method that samples", pairs[0]);
    ck_assert_msg(strstr(GetOutput(), expected) != NULL, "%s", GetOutput());
    LeaveFolder();
}
END_TEST

START_TEST(a_detection_that_failed_is_replayed_like_the_others)
{
    EnterFolder();
    qcScene* scene = qcMakeScene(NULL);
    CHECK_OK(qcScene_Record(scene, "a.qcr"));
    qcSoup soup = qcSoup_MakeFoldedCloth(2, 16, 0.02, 0.03);
    qcBodyDef bodyDef = qcBodyDefOf(&soup);
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &bodyDef, &id));
    for (int i = 0; i < qc_detections; i++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.margin = 0.01;
        def.maxPairs = i == 1 ? 3 : 0;
        const qcResult* result;
        ck_assert_int_eq(qcScene_Detect(scene, &def, &result), i == 1 ? qc_statusTooManyPairs : qc_statusOk);
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
    ck_assert_msg(Run(REPLAY " a.qcr") == 0, "%s%s", GetOutput(), GetErrors());
    ck_assert_ptr_nonnull(strstr(GetOutput(), "4 results are the recorded ones, 0 differ"));
    ck_assert_int_eq(Run(REPLAY " --method brute --each a.qcr"), 0);
    LeaveFolder();
}
END_TEST

START_TEST(operations_are_listed_with_their_bytes)
{
    EnterFolder();
    size_t pairs[qc_detections];
    MakeRecording(pairs);
    ck_assert_int_eq(Run(REPLAY " --list a.qcr"), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "add body 0: 512 triangles, 289 vertices, double, deforming"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "set vertices 0: 289, double"));
    char expected[64];
    snprintf(expected, sizeof expected, "detect by auto, margin 0.03: %zu pairs, 0 contacts", pairs[3]);
    ck_assert_msg(strstr(GetOutput(), expected) != NULL, "%s", GetOutput());
    ck_assert_ptr_nonnull(strstr(GetOutput(), "  end\n"));
    LeaveFolder();
}
END_TEST

START_TEST(boxes_that_are_there_go_at_a_reset)
{
    static const char* const options[] = {
        "--method brute",
#ifdef QC_HAS_BROADPHASE
        "--method recorded",
#endif
    };
    EnterFolder();
    const double bounds[6] = {0.0, 0.0, 0.0, 1.0, 1.0, 1.0};
    const qcBoxPair pair = {0, 1};
    for (int again = 0; again < 2; again++)
    {
        qcBoxRecorder* recorder;
        CHECK_OK(qcBoxRecorder_Open("a.qcr", sizeof(float), &recorder));
        for (uint32_t id = 0; id < 2; id++)
            qcBoxRecorder_Add(recorder, id, bounds, 1, 1);
        qcBoxRecorder_Begin(recorder);
        qcBoxRecorder_EndPairs(recorder, &pair, 1, false, NULL, 0);
        qcBoxRecorder_Reset(recorder);
        if (again)
            qcBoxRecorder_Add(recorder, 0, bounds, 1, 1);
        qcBoxRecorder_Begin(recorder);
        qcBoxRecorder_EndPairs(recorder, NULL, 0, false, NULL, 0);
        CHECK_OK(qcBoxRecorder_Close(recorder));
        for (size_t i = 0; i < sizeof options / sizeof options[0]; i++)
        {
            ck_assert_msg(Run(REPLAY " %s a.qcr", options[i]) == 0, "%s%s", GetOutput(), GetErrors());
            ck_assert_ptr_nonnull(strstr(GetOutput(), "2 results are the recorded ones, 0 differ"));
        }
    }
    LeaveFolder();
}
END_TEST

START_TEST(help_names_both_kinds_of_recordings)
{
    EnterFolder();
    ck_assert_int_eq(Run(REPLAY " --help"), 0);
    static const char* const words[] = {"qcScene_Record", "qcBroadphase::record", "qc-replay-double", "Exit status: 0"};
    for (size_t i = 0; i < sizeof words / sizeof words[0]; ++i)
        ck_assert_msg(strstr(GetOutput(), words[i]) != NULL, "%s", words[i]);
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_and_damage_are_named)
{
    EnterFolder();
    size_t pairs[qc_detections];
    MakeRecording(pairs);
    ck_assert_int_eq(Run(REPLAY), 2);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "no FILE is named"));
    ck_assert_int_eq(Run(REPLAY " a.qcr b.qcr"), 2);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "'b.qcr'"));
    ck_assert_int_eq(Run(REPLAY " --method swep a.qcr"), 2);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "--method: 'swep' is not one of recorded, brute"));
    ck_assert_int_eq(Run(REPLAY " --from 3 --to 2 a.qcr"), 2);
    ck_assert_int_eq(Run(REPLAY " --from 5 a.qcr"), 2);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "--from 5: the recording has fewer detections"));
    ck_assert_int_eq(Run(REPLAY " b.qcr"), 3);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "qc-replay: b.qcr can't be opened: No such file or directory"));
    ck_assert_int_eq(Run(REPLAY " --csv no/folder/a.csv a.qcr"), 1);
    ck_assert_int_eq(Run("ln -s a.qcr link; " REPLAY " --csv link a.qcr"), 2);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "--csv: 'link' would replace 'a.qcr', which is read"));
    ck_assert_int_eq(Run(REPLAY " --csv - a.qcr"), 2);
    ck_assert_int_eq(Run(REPLAY " --list --csv a.csv a.qcr"), 2);
    ck_assert_int_eq(Run(REPLAY " --list --to 1 a.qcr"), 2);
    static const char* const options[] = {"", "--list", "--each"};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++)
    {
        ck_assert_int_eq(Run(REPLAY " %s a.qcr >/dev/full", options[i]), 1);
        ck_assert_ptr_nonnull(strstr(GetErrors(), "standard output: No space left on device"));
    }
    ck_assert_int_eq(Run("head -c -200 a.qcr >b.qcr; " REPLAY " b.qcr"), 3);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "b.qcr: operation 8 at byte"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "3 results are the recorded ones, 0 differ"));
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("replay_program", a_recording_replays_equal_by_every_method_that_never_misses,
             a_result_that_differs_is_named_and_fails, pairs_that_a_sampling_method_misses_are_counted,
             a_detection_that_failed_is_replayed_like_the_others, operations_are_listed_with_their_bytes,
             boxes_that_are_there_go_at_a_reset, help_names_both_kinds_of_recordings, mistakes_and_damage_are_named)
