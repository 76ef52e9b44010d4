/// @file
/// Status codes, messages, memory, logging, threads, version: shared by all parts of the C library.
///
/// Thread-safety: any thread may call these functions, but set the hooks before any other call; qcSetParallelFor also
/// later, while no other call runs.
/// Floating-point modes: results don't depend on the caller's rounding mode, FTZ, DAZ or traps. Each call computes in
/// the default modes and restores the caller's. Callbacks run in the default modes, but a qcBoxFunction and a
/// qcLoopFunction in the caller's.
#ifndef QUICKCULLIDE_BASE_H
#define QUICKCULLIDE_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Marks exported names. Define QC_STATIC to link the static library.
#if defined(QC_STATIC)
#define QC_API
#else
#define QC_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define QC_VERSION_MAJOR 0  ///< Grows with each incompatible release, from 1.0.0 on.
#define QC_VERSION_MINOR 8  ///< Grows with each release that adds something; before 1.0.0 it may break the ABI.
#define QC_VERSION_PATCH 38 ///< Grows with each release that only fixes something.
/// The version of these headers as one number: 10000 * major + 100 * minor + patch.
///
/// A definition (a struct that begins with structSize) may gain fields at its end. Start from its default function,
/// which sets structSize. Fields that a caller's older header doesn't have keep their defaults. A newer header works
/// with an older library while all fields that the library doesn't have are 0; otherwise qc_statusBadInput. All other
/// structs keep their layout within a minor version, which is the version of the shared library's name.
#define QC_VERSION (10000 * QC_VERSION_MAJOR + 100 * QC_VERSION_MINOR + QC_VERSION_PATCH)

/// The version of the loaded library, encoded as QC_VERSION. It differs from QC_VERSION if the program was compiled
/// with the headers of another release. O(1). Any thread.
QC_API uint32_t qcVersion(void);

/// The result of a call. After anything but qc_statusOk all objects are as they were before the call. Null pointers are
/// refused by qc_statusBadInput; functions without a status must not be given any unless their comment allows it.
typedef enum qcStatus
{
    /// The call did what it should.
    qc_statusOk = 0,
    /// An argument is invalid; qcLastMessage names the argument, the body and the element.
    qc_statusBadInput = 1,
    /// The GL device does not exist on this machine, or failed.
    qc_statusDevice = 2,
    /// An allocation failed.
    qc_statusOutOfMemory = 3,
    /// The GL context of the device is lost, for example after a GPU reset; a new one opens by itself, see
    /// qcDeviceDef::reopenSeconds, or by qcDevice_Reopen. A qcDeviceBuffer that was opened before that returns it ever
    /// after: close and open it again.
    qc_statusDeviceLost = 4,
    /// A file could not be created, written or read, or it is damaged; qcLastMessage names it and the place.
    qc_statusFile = 5,
    /// More pairs than the caller allows (qcDetectDef::maxPairs).
    qc_statusTooManyPairs = 6
} qcStatus;

/// The message of this thread's last call that failed. Never null. Valid until the thread's next failing call.
QC_API const char* qcLastMessage(void);

/// Fails a call of a layer over this library, such as the parts for Bullet: the printf-style message, cut after 511
/// bytes, becomes this thread's qcLastMessage. Returns `status`.
__attribute__((format(printf, 2, 3))) QC_API qcStatus qcFail(qcStatus status, const char* format, ...);

/// The name of a status, such as "bad input". Never null; static.
QC_API const char* qcStatus_Name(qcStatus status);

/// Allocates `size` bytes (> 0) aligned to 64, or returns null. Must not throw.
typedef void* qcAllocateFunction(size_t size, void* context);
/// Frees memory that the allocate function returned for this `size`.
typedef void qcFreeFunction(void* memory, size_t size, void* context);

/// Replaces the library's heap. Null functions restore the default. Both functions are called from any thread, several
/// at once. qc_statusBadInput: qcGetByteCount() is not zero, or only one function is given.
QC_API qcStatus qcSetAllocator(qcAllocateFunction* allocate, qcFreeFunction* release, void* context);

/// Bytes that the library holds at present. Zero once every object is destroyed. O(1).
QC_API size_t qcGetByteCount(void);

/// Receives one line of text without a newline, for example the reason for a fallback. `line` is valid during the call.
/// It may be called on several threads at once. Must not throw.
typedef void qcLogFunction(const char* line, void* context);

/// Sets the function that receives log lines. Null, the default: lines are discarded.
QC_API void qcSetLog(qcLogFunction* log, void* context);

/// One worker of a parallel loop: processes blocks of the loop until none is left, then returns. It needs 160 KB of
/// stack, as all functions of the library do.
typedef void qcTask(uint32_t index, void* taskContext);

/// A parallel-for of the host: calls task(index, taskContext) once for each index below `count`, in any order, on any
/// threads, and returns when all calls have returned. You may skip calls that haven't started once any call has
/// returned. If you run none, the library does the work itself after you return. Must not throw. It is called on the
/// thread that runs the step (see qcScene_DetectBegin); several threads may call it at once if they run different ones.
typedef void qcParallelForFunction(uint32_t count, qcTask* task, void* taskContext, void* context);

/// Runs the library's loops on the host's threads, with at most one task for each of `workers` threads (1 to 256, more
/// count as 256). Loops too short to profit stay on the calling thread. Null restores the default: threads of the
/// library's own, which sleep between loops. Before one is woken, its affinity loses the caller's core; threads that
/// loop functions start inherit that. Results depend on neither the number of threads nor their floating-point modes.
/// `context` must stay valid until the next call of this function.
/// qc_statusBadInput: a function with 0 workers; nothing changes.
QC_API qcStatus qcSetParallelFor(qcParallelForFunction* parallelFor, uint32_t workers, void* context);

/// The body of a loop. `worker` is below the number of workers of the loop; two calls at the same time never have the
/// same one, so it can index memory of the caller's. Must not throw.
typedef void qcLoopFunction(size_t index, uint32_t worker, void* loopContext);

/// Number of workers of the library's loops: those of qcSetParallelFor, by default one for each core that the process
/// may use. 1 to 256. O(1).
QC_API uint32_t qcGetWorkerCount(void);

/// Runs a loop of the caller's where the library's own loops run: on the host's threads (qcSetParallelFor) or on the
/// library's. Calls function(index, worker, loopContext) once for each index below `count`, in any order, on at most
/// `workers` threads (0: qcGetWorkerCount()), and returns when all calls have returned. Several threads may call it at
/// once; the library's own threads run one loop at a time, further loops then stay on their calling threads.
QC_API void qcParallelFor(uint32_t workers, size_t count, qcLoopFunction* function, void* loopContext);

#ifdef __cplusplus
}
#endif

#endif
