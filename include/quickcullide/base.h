// Statuses, messages, hooks: what every part of the C ABI shares.
//
// Thread-safety: the hooks are set before anything else is called; everything else here may be
// called from any thread.
#ifndef QUICKCULLIDE_BASE_H
#define QUICKCULLIDE_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(QC_STATIC)
#define QC_API
#elif defined(_WIN32)
#define QC_API __declspec(dllexport)
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
    qc_statusOutOfMemory = 3
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

/// Replaces the heap of the library. Null functions bring the default back.
/// Call it while qcGetByteCount() is zero; otherwise qc_statusBadInput.
QC_API qcStatus qcSetAllocator(qcAllocateFunction* allocate, qcFreeFunction* release, void* context);

/// Bytes that the library holds at this moment. Zero once every object is destroyed.
QC_API size_t qcGetByteCount(void);

/// Receives one line of text (no newline): a fallback, a skipped device.
typedef void qcLogFunction(const char* line, void* context);

/// Sets where log lines go. Null (the default): nowhere.
QC_API void qcSetLog(qcLogFunction* log, void* context);

#ifdef __cplusplus
}
#endif

#endif
