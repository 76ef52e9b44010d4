// Stands before libcheck's header, for all tests: an assertion that holds passes its place to libcheck once, not each
// time. libcheck writes the place into a file, so that the report of a crash names the last one: a call of the system
// for each assertion that holds, millions in some tests.
#ifndef QC_TESTS_SUPPORT_QUICK_CHECK_CHECK_H
#define QC_TESTS_SUPPORT_QUICK_CHECK_CHECK_H

#include_next <check.h>

// An old name of ck_abort_msg, and a function of the standard library's streams.
#undef fail

#include <stdint.h>

/// Marks a line of a source that was not passed before. Two lines with one hash count as one.
static inline void qcMarkPoint(const char* file, int line)
{
    static unsigned char s_passed[4096];
    unsigned char* passed = &s_passed[((uintptr_t)file * 31 + (uintptr_t)line) % sizeof s_passed];
    if (__atomic_exchange_n(passed, 1, __ATOMIC_RELAXED) == 0)
        _mark_point(file, line);
}

#define _mark_point(file, line) qcMarkPoint(file, line)

#endif
