// The set transitions of section 4.1, each line of the paper a test.
#include "support/suite.h"
#include "scene/visibility_sets.h"

START_TEST(the_first_pass_tests_sfv_and_nfv_and_renders_ffv_and_nfv)
{
    ck_assert(!qcVisibilitySet_IsTested(qc_setFfv, 1, true));
    ck_assert(qcVisibilitySet_IsTested(qc_setSfv, 1, true));
    ck_assert(qcVisibilitySet_IsTested(qc_setNfv, 1, true));
    ck_assert(qcVisibilitySet_IsRendered(qc_setFfv, 1, true));
    ck_assert(!qcVisibilitySet_IsRendered(qc_setSfv, 1, true));
    ck_assert(qcVisibilitySet_IsRendered(qc_setNfv, 1, true));
}
END_TEST

START_TEST(the_second_pass_tests_ffv_and_nfv_and_renders_sfv_and_nfv)
{
    ck_assert(qcVisibilitySet_IsTested(qc_setFfv, 2, true));
    ck_assert(!qcVisibilitySet_IsTested(qc_setSfv, 2, true));
    ck_assert(qcVisibilitySet_IsTested(qc_setNfv, 2, true));
    ck_assert(!qcVisibilitySet_IsRendered(qc_setFfv, 2, true));
    ck_assert(qcVisibilitySet_IsRendered(qc_setSfv, 2, true));
    ck_assert(qcVisibilitySet_IsRendered(qc_setNfv, 2, true));
}
END_TEST

START_TEST(a_pruned_primitive_is_neither_tested_nor_rendered)
{
    for (int pass = 1; pass <= 2; pass++)
        for (int quick = 0; quick < 2; quick++)
        {
            ck_assert(!qcVisibilitySet_IsTested(qc_setBfv, pass, quick));
            ck_assert(!qcVisibilitySet_IsRendered(qc_setBfv, pass, quick));
        }
}
END_TEST

START_TEST(cullide_tests_and_renders_all_but_bfv_in_both_passes)
{
    for (int pass = 1; pass <= 2; pass++)
        for (int set = qc_setFfv; set <= qc_setNfv; set++)
        {
            ck_assert(qcVisibilitySet_IsTested((qcVisibilitySet)set, pass, false));
            ck_assert(qcVisibilitySet_IsRendered((qcVisibilitySet)set, pass, false));
        }
}
END_TEST

START_TEST(visible_in_the_first_pass_moves_nfv_to_ffv_and_prunes_sfv)
{
    ck_assert_int_eq(qcVisibilitySet_After(qc_setNfv, 1, true), qc_setFfv);
    ck_assert_int_eq(qcVisibilitySet_After(qc_setSfv, 1, true), qc_setBfv); // lemma 4
    ck_assert_int_eq(qcVisibilitySet_After(qc_setFfv, 1, true), qc_setFfv);
}
END_TEST

START_TEST(visible_in_the_second_pass_moves_nfv_to_sfv_and_prunes_ffv)
{
    ck_assert_int_eq(qcVisibilitySet_After(qc_setNfv, 2, true), qc_setSfv);
    ck_assert_int_eq(qcVisibilitySet_After(qc_setFfv, 2, true), qc_setBfv); // lemma 3
    ck_assert_int_eq(qcVisibilitySet_After(qc_setSfv, 2, true), qc_setSfv);
}
END_TEST

START_TEST(visible_in_both_passes_of_one_view_prunes_nfv)
{
    qcVisibilitySet set = qcVisibilitySet_After(qcVisibilitySet_After(qc_setNfv, 1, true), 2, true);
    ck_assert_int_eq(set, qc_setBfv); // lemma 5
}
END_TEST

START_TEST(a_hidden_primitive_stays_in_its_set)
{
    for (int pass = 1; pass <= 2; pass++)
        for (int set = qc_setBfv; set <= qc_setNfv; set++)
            ck_assert_int_eq(qcVisibilitySet_After((qcVisibilitySet)set, pass, false), set);
}
END_TEST

START_TEST(primitives_of_one_collision_free_set_are_not_paired)
{
    const unsigned sets[] = {qc_setBfv, qc_setFfv, qc_setSfv, qc_setNfv};
    const bool expected[4][4] = {{false, false, false, false},
                                 {false, false, true, true},
                                 {false, true, false, true},
                                 {false, true, true, true}};
    for (int a = 0; a < 4; a++)
        for (int b = 0; b < 4; b++)
            ck_assert_int_eq(qcVisibilitySet_MayCollide(sets[a], sets[b]), expected[a][b]);
}
END_TEST

START_TEST(only_quick_passes_ffv_and_sfv_from_view_to_view)
{
    for (int set = qc_setBfv; set <= qc_setNfv; set++)
        ck_assert_int_eq(qcVisibilitySet_NextView((qcVisibilitySet)set, true), set);
    ck_assert_int_eq(qcVisibilitySet_NextView(qc_setFfv, false), qc_setNfv);
    ck_assert_int_eq(qcVisibilitySet_NextView(qc_setSfv, false), qc_setNfv);
    ck_assert_int_eq(qcVisibilitySet_NextView(qc_setBfv, false), qc_setBfv);
}
END_TEST

QC_RUN_TESTS("visibility sets", the_first_pass_tests_sfv_and_nfv_and_renders_ffv_and_nfv,
             the_second_pass_tests_ffv_and_nfv_and_renders_sfv_and_nfv,
             a_pruned_primitive_is_neither_tested_nor_rendered, cullide_tests_and_renders_all_but_bfv_in_both_passes,
             visible_in_the_first_pass_moves_nfv_to_ffv_and_prunes_sfv,
             visible_in_the_second_pass_moves_nfv_to_sfv_and_prunes_ffv, visible_in_both_passes_of_one_view_prunes_nfv,
             a_hidden_primitive_stays_in_its_set, primitives_of_one_collision_free_set_are_not_paired,
             only_quick_passes_ffv_and_sfv_from_view_to_view)
