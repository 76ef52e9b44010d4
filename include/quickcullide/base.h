// Statuses, messages, hooks: what every part of the C ABI shares.
//
// Thread-safety: the hooks are set before anything else is called, that for threads also later, while no
// other call runs; everything else here may be called from any thread.
//
// Versions: a definition (a struct that begins with structSize) may gain fields at its end. Start from its default
// function, which sets structSize. Fields that a caller's older header doesn't have keep their defaults. A newer header
// works with an older library while all fields that the library doesn't have are 0; otherwise qc_statusBadInput. All
// other structs keep their layout within a minor version, which is the version of the shared library's name.
//
// Floating-point modes: results don't depend on the caller's rounding mode, nor on whether it flushes subnormals (FTZ,
// DAZ) or traps. Each call computes in the default modes and puts the caller's back. A qcBoxFunction runs in the modes
// of the caller; all other callbacks run in the default modes.
#ifndef QUICKCULLIDE_BASE_H
#define QUICKCULLIDE_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(QC_STATIC)
#define QC_API
#else
#define QC_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define QC_VERSION_MAJOR 0
#define QC_VERSION_MINOR 1
#define QC_VERSION_PATCH 0

/// What a call says of itself. Anything but qc_statusOk leaves every object as it was before the call.
typedef enum qcStatus
{
    qc_statusOk = 0,
    /// The caller's mistake; qcLastMessage names the argument, the body and the element.
    qc_statusBadInput = 1,
    /// The named GL device does not exist here, or failed.
    qc_statusDevice = 2,
    /// An allocation failed.
    qc_statusOutOfMemory = 3,
    /// The device's GL context is lost, as after a GPU reset; qcDevice_Reopen opens it anew.
    qc_statusDeviceLost = 4
} qcStatus;

/// The message of the last call of this thread that did not return qc_statusOk.
/// Never null; valid until this thread's next failing call.
QC_API const char* qcLastMessage(void);

/// The name of a status, such as "bad input". Never null.
QC_API const char* qcStatus_Name(qcStatus status);

/// Allocates `size` bytes (> 0) aligned to 64, or returns null.
typedef void* qcAllocateFunction(size_t size, void* context);
/// Frees what the allocate function returned for this `size`.
typedef void qcFreeFunction(void* memory, size_t size, void* context);

/// Replaces the heap of the library. Null functions bring the default back. Any thread may call them, several at once.
/// Call it while qcGetByteCount() is zero; otherwise qc_statusBadInput.
QC_API qcStatus qcSetAllocator(qcAllocateFunction* allocate, qcFreeFunction* release, void* context);

/// Bytes that the library holds at this moment. Zero once every object is destroyed.
QC_API size_t qcGetByteCount(void);

/// Receives one line of text (no newline): a fallback, a skipped device.
typedef void qcLogFunction(const char* line, void* context);

/// Sets where log lines go. Null (the default): nowhere.
QC_API void qcSetLog(qcLogFunction* log, void* context);

/// A thread's share of a loop of the library: it takes what is left to do, piece by piece, and returns when nothing is.
typedef void qcTask(uint32_t index, void* taskContext);

/// Calls task(index, taskContext) for each index below `count`, none twice, in any order and on any threads, at the
/// same time or not, and returns when all calls have. Calls not begun when another one has returned may be left out:
/// they would find nothing to do. If all are, the calling thread does the work after the return. Must not throw. It is
/// called on the thread that uses the scene: on several at once if several scenes are used so.
typedef void qcParallelForFunction(uint32_t count, qcTask* task, void* taskContext, void* context);

/// Runs the library's loops on the host's threads: at most one task for each of `workers` threads (1 or more; beyond
/// 256 as 256), fewer where a query asks for fewer. Loops too short to be worth it stay on the calling thread. Null
/// brings the default back: threads of the library's own, asleep between loops. Results don't depend on any of it, nor
/// on the floating-point modes of the host's threads: tasks set their own and put these back.
/// `context` is in use until the next call of this. qc_statusBadInput: a function without workers; nothing changes.
QC_API qcStatus qcSetParallelFor(qcParallelForFunction* parallelFor, uint32_t workers, void* context);

#ifdef __cplusplus
}
#endif

#endif
