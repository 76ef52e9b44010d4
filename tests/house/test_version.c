// The version is the same in CMake, in the headers and in the library.
#include "support/suite.h"

#include <quickcullide/quickcullide.h>

#include <check.h>
#include <stdio.h>

START_TEST(headers_have_the_version_of_the_project)
{
    char text[32];
    snprintf(text, sizeof(text), "%d.%d.%d", QC_VERSION_MAJOR, QC_VERSION_MINOR, QC_VERSION_PATCH);
    ck_assert_str_eq(text, QC_PROJECT_VERSION);
}
END_TEST

START_TEST(the_library_has_the_version_of_its_headers)
{
    ck_assert_uint_eq(qcVersion(), QC_VERSION);
    ck_assert_uint_eq(qcVersion() / 10000, QC_VERSION_MAJOR);
    ck_assert_uint_eq(qcVersion() / 100 % 100, QC_VERSION_MINOR);
    ck_assert_uint_eq(qcVersion() % 100, QC_VERSION_PATCH);
}
END_TEST

QC_RUN_TESTS("version", headers_have_the_version_of_the_project, the_library_has_the_version_of_its_headers)
