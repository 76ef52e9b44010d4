// Numbers in mesh files: each becomes the float or the double nearest to it. The oracle is the C library.
#include "common/mesh_io/mesh_parser.h"
#include "support/suite.h"

#include <check.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void AssertRoundedAsTheLibraryDoes(const char* text)
{
    float single;
    double twice;
    ck_assert_msg(qcParseFloat(text, text + strlen(text), &single), "%s", text);
    ck_assert_msg(qcParseDouble(text, text + strlen(text), &twice), "%s", text);
    float expectedSingle = strtof(text, NULL);
    double expectedTwice = strtod(text, NULL);
    ck_assert_msg(memcmp(&single, &expectedSingle, sizeof single) == 0, "%s: %a, not %a", text, single, expectedSingle);
    ck_assert_msg(memcmp(&twice, &expectedTwice, sizeof twice) == 0, "%s: %a, not %a", text, twice, expectedTwice);
}

START_TEST(decimals_are_rounded_to_nearest)
{
    srand(1);
    for (int round = 0; round < 100000; ++round)
    {
        char text[128];
        size_t length = 0;
        int whole = rand() % 12, fraction = rand() % 30;
        if (rand() % 2)
            text[length++] = "+-"[rand() % 2];
        for (int i = 0; i < whole; ++i)
            text[length++] = (char)('0' + rand() % 10);
        if (fraction > 0 || whole == 0)
            text[length++] = '.';
        for (int i = 0; i < fraction || (whole == 0 && i == 0); ++i)
            text[length++] = (char)('0' + rand() % 10);
        text[length] = 0;
        if (rand() % 3 == 0)
            snprintf(text + length, sizeof text - length, "e%d", rand() % 700 - 350);
        AssertRoundedAsTheLibraryDoes(text);
    }
}
END_TEST

START_TEST(points_halfway_between_two_floats_are_rounded_to_even)
{
    srand(2);
    for (int round = 0; round < 20000; ++round)
    {
        uint32_t bits = ((uint32_t)rand() << 8 ^ (uint32_t)rand()) & 0x7fffffff;
        float lower;
        memcpy(&lower, &bits, sizeof lower);
        if (!isfinite(lower))
            continue;
        double halfway = 0.5 * ((double)lower + (double)nextafterf(lower, INFINITY));
        char text[400];
        // 300 digits hold every such point exactly; one digit more or less is beside it.
        snprintf(text, sizeof text, "%.300g", halfway);
        AssertRoundedAsTheLibraryDoes(text);
        snprintf(text, sizeof text, "%.17g", halfway);
        AssertRoundedAsTheLibraryDoes(text);
        snprintf(text, sizeof text, "%.9g", lower);
        AssertRoundedAsTheLibraryDoes(text);
    }
}
END_TEST

START_TEST(a_digit_far_behind_the_point_still_decides_the_rounding)
{
    // 1 + 2^-24 lies halfway between two floats, 1 + 2^-53 halfway between two doubles.
    static const char* halfways[] = {"1.000000059604644775390625",
                                     "1.00000000000000011102230246251565404236316680908203125"};
    for (int i = 0; i < 2; ++i)
    {
        for (int zeros = 0; zeros <= 3000; zeros += 500)
        {
            char text[4096];
            size_t length = strlen(halfways[i]);
            memcpy(text, halfways[i], length);
            memset(text + length, '0', (size_t)zeros);
            text[length + (size_t)zeros] = 0;
            AssertRoundedAsTheLibraryDoes(text);
            strcat(text, "1");
            AssertRoundedAsTheLibraryDoes(text);
        }
    }
}
END_TEST

START_TEST(exponents_of_any_length_end_at_zero_or_infinity)
{
    static const char* texts[] = {"1e-400",
                                  "1e400",
                                  "0e999999999999999999999999",
                                  "1e18446744073709551616",
                                  "1e-18446744073709551616",
                                  "1e-99999999999999999999999",
                                  "1e99999999999999999999999",
                                  "3.4028235e38",
                                  "3.4028236e38",
                                  "1e-46",
                                  "4.9e-324",
                                  "2.4703282292062327e-324",
                                  "000000000000000000000000000001",
                                  "-0",
                                  "+0.0"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i)
        AssertRoundedAsTheLibraryDoes(texts[i]);
}
END_TEST

START_TEST(the_locale_of_the_program_does_not_matter)
{
    // With one of these, where it is installed, strtod expects a comma.
    static const char* const locales[] = {"de_DE.UTF-8", "de_DE", "fr_FR.UTF-8", "fr_FR"};
    for (size_t i = 0; i < sizeof locales / sizeof locales[0]; ++i)
        setlocale(LC_ALL, locales[i]);
    static const char texts[2][40] = {"1.5", "1.500000000000000000000000000001"};
    for (int i = 0; i < 2; ++i)
    {
        float single;
        double twice;
        ck_assert(qcParseFloat(texts[i], texts[i] + strlen(texts[i]), &single));
        ck_assert(qcParseDouble(texts[i], texts[i] + strlen(texts[i]), &twice));
        ck_assert(single == 1.5f && twice == 1.5);
    }
    setlocale(LC_ALL, "C");
}
END_TEST

START_TEST(text_that_is_no_decimal_number_is_refused)
{
    static const char* texts[] = {"",    "-",   ".",    "e5",  "1e",   "1e+", "1.2.3", "0x10", "nan",   "inf",
                                  "1,5", "1 2", "1.5f", "--1", "1e5.", "1d5", "+-1",   "1_0",  "1e5e5", "INFINITY"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i)
    {
        float single;
        double twice;
        ck_assert_msg(!qcParseFloat(texts[i], texts[i] + strlen(texts[i]), &single), "%s", texts[i]);
        ck_assert_msg(!qcParseDouble(texts[i], texts[i] + strlen(texts[i]), &twice), "%s", texts[i]);
    }
}
END_TEST

int main(void)
{
    TCase* numbers = qcMakeCase("mesh_number");
    tcase_add_test(numbers, decimals_are_rounded_to_nearest);
    tcase_add_test(numbers, points_halfway_between_two_floats_are_rounded_to_even);
    tcase_add_test(numbers, a_digit_far_behind_the_point_still_decides_the_rounding);
    tcase_add_test(numbers, exponents_of_any_length_end_at_zero_or_infinity);
    tcase_add_test(numbers, the_locale_of_the_program_does_not_matter);
    tcase_add_test(numbers, text_that_is_no_decimal_number_is_refused);
    return qcRunCase("mesh_number", numbers);
}
