// The main function of a test program, and one case of several tests.
#ifndef QC_TESTS_SUPPORT_SUITE_H
#define QC_TESTS_SUPPORT_SUITE_H

#include <check.h>

/// Stands before the body of a file's main function. Where several files are one program (qc_test_group in
/// tests/CMakeLists.txt), the body belongs to a function that the program calls for the name of the file.
#ifdef QC_TEST_GROUP
#include "support/test_group.h"
#define QC_TEST_MAIN() QC_TEST_MAIN_NUMBER(__COUNTER__)
#else
#define QC_TEST_MAIN() int main(void)
#endif

/// Runs a suite that is put together by hand, and frees it; the program's exit status.
static inline int qcRunSuite(Suite* suite)
{
    SRunner* runner = srunner_create(suite);
    srunner_run_all(runner, CK_NORMAL);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed != 0;
}

/// The case of a suite that has only one, for qcRunCase.
static inline TCase* qcMakeCase(const char* name)
{
    TCase* testCase = tcase_create(name);
    tcase_set_timeout(testCase, 300); // a bound against hanging, not a claim about speed
    return testCase;
}

/// Runs a case as a suite, and frees it; the program's exit status.
static inline int qcRunCase(const char* name, TCase* testCase)
{
    Suite* suite = suite_create(name);
    suite_add_tcase(suite, testCase);
    return qcRunSuite(suite);
}

/// Runs the tests as one case; the program's exit status.
static inline int qcRunTests(const char* name, const TTest* const* tests, int count)
{
    TCase* testCase = qcMakeCase(name);
    for (int i = 0; i < count; i++)
        tcase_add_test(testCase, tests[i]);
    return qcRunCase(name, testCase);
}

#define QC_RUN_LISTED(name, ...)                                                                                       \
    const TTest* const tests[] = {__VA_ARGS__};                                                                        \
    return qcRunTests(name, tests, (int)(sizeof tests / sizeof tests[0]))

#define QC_RUN_TESTS(name, ...)                                                                                        \
    QC_TEST_MAIN()                                                                                                     \
    {                                                                                                                  \
        QC_RUN_LISTED(name, __VA_ARGS__);                                                                              \
    }

#endif
