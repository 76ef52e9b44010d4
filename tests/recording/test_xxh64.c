// Hashes by the reference implementation (xxHash 0.8), for sizes that end in each part of the algorithm.
#include "quickcullide/hash.h"
#include "support/suite.h"

#include <string.h>

START_TEST(hashes_are_those_of_the_reference)
{
    const struct
    {
        const char* text;
        uint64_t hash;
    } known[] = {{"", 0xef46db3751d8e999u},
                 {"a", 0xd24ec4f1a98c6e5bu},
                 {"abc", 0x44bc2cf5ad770999u},
                 {"Nobody inspects the spammish repetition", 0xfbcea83c8a378bf1u}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        ck_assert_uint_eq(qcXxh64(known[i].text, strlen(known[i].text), 0), known[i].hash);
    ck_assert_uint_ne(qcXxh64("abc", 3, 1), qcXxh64("abc", 3, 0));
    ck_assert_uint_eq(qcXxh64(NULL, 0, 0), known[0].hash);
}
END_TEST

QC_RUN_TESTS("xxh64", hashes_are_those_of_the_reference)
