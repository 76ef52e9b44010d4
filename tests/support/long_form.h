// Tests with two forms: a short one among all tests, and a long one by tests/run.sh --long, which sets QC_TEST_LONG and
// runs the tests that have the label `long`.
#ifndef QC_TESTS_SUPPORT_LONG_FORM_H
#define QC_TESTS_SUPPORT_LONG_FORM_H

#include <stdbool.h>
#include <stdlib.h>

static inline bool qcIsLongForm(void)
{
    return getenv("QC_TEST_LONG") != NULL;
}

#endif
