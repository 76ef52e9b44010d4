// What the tests leave out under a sanitizer.
#ifndef QC_TESTS_SUPPORT_SANITIZERS_H
#define QC_TESTS_SUPPORT_SANITIZERS_H

#include <stdbool.h>
#include <stdio.h>

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define QC_HAS_THREAD_SANITIZER
#endif
#if __has_feature(memory_sanitizer)
#define QC_HAS_MEMORY_SANITIZER
#endif
#if __has_feature(address_sanitizer)
#define QC_HAS_ADDRESS_SANITIZER
#endif
#elif defined(__SANITIZE_THREAD__)
#define QC_HAS_THREAD_SANITIZER
#elif defined(__SANITIZE_ADDRESS__)
#define QC_HAS_ADDRESS_SANITIZER
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

/// Whether a driver of GL may be unloaded. The thread sanitizer's list of libraries that it ignores doesn't allow that.
static inline bool qcCanUnloadDrivers(void)
{
#ifdef QC_HAS_THREAD_SANITIZER
    printf("skipped: the thread sanitizer allows no driver to be unloaded\n");
    return false;
#else
    return true;
#endif
}

/// Whether fork() may wait for other threads. The memory sanitizer's fork() first takes the locks of its own allocator,
/// and then calls the handlers that wait.
static inline bool qcForksCanWait(void)
{
#ifdef QC_HAS_MEMORY_SANITIZER
    printf("skipped: no thread allocates while the memory sanitizer forks\n");
    return false;
#else
    return true;
#endif
}

/// Whether the address space may be limited. Sanitizers need terabytes of it for what they know of each byte.
static inline bool qcCanLimitAddresses(void)
{
#if defined(QC_HAS_ADDRESS_SANITIZER) || defined(QC_HAS_MEMORY_SANITIZER) || defined(QC_HAS_THREAD_SANITIZER)
    printf("skipped: sanitizers need more addresses\n");
    return false;
#else
    return true;
#endif
}

#endif
