// Cases of loops that take long, in programs that are there for both precisions of Bullet.
#ifndef QC_TESTS_BULLET_ADD_LOOP_H
#define QC_TESTS_BULLET_ADD_LOOP_H

#include "support/long_form.h"

#include <LinearMath/btScalar.h>

#include <check.h>

/// Adds the cases of a loop. In the short form each case runs in one of the precisions: a third of them in double
/// precision (of three in a row the first, of the next three the second, and so on), the others in single precision. In
/// the long form all run in both.
static inline void qcAddLoop(TCase* tests, const TTest* test, int count)
{
    const bool isDouble = sizeof(btScalar) == sizeof(double);
    for (int i = 0; i < count; i++)
        if (qcIsLongForm() || (i % 3 == i / 3 % 3) == isDouble)
            tcase_add_loop_test(tests, test, i, i + 1);
}

#endif
