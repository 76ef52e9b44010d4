// What the tests leave out under a sanitizer.
#ifndef QC_TESTS_SUPPORT_SANITIZERS_H
#define QC_TESTS_SUPPORT_SANITIZERS_H

#include <stdbool.h>
#include <stdio.h>

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define QC_HAS_THREAD_SANITIZER
#endif
#elif defined(__SANITIZE_THREAD__)
#define QC_HAS_THREAD_SANITIZER
#endif

/// Whether a child of a process with several threads may start threads of its own. The thread sanitizer's tables still
/// have the parent's threads there, and it refuses a new one with the handle of one of them.
static inline bool qcChildrenCanStartThreads(void)
{
#ifdef QC_HAS_THREAD_SANITIZER
    printf("skipped: the thread sanitizer knows no threads of children\n");
    return false;
#else
    return true;
#endif
}

#endif
