// The only place that allocates: every block goes through the host's hooks and is counted.
#ifndef QC_BASE_MEMORY_H
#define QC_BASE_MEMORY_H

#include "quickcullide/base.h"

/// Null when there is no memory (or size is 0). Aligned to 64 bytes. Not cleared.
void* qcAllocate(size_t size);
/// Like qcAllocate, all zero.
void* qcAllocateZeroed(size_t size);
/// `size` is the one that was allocated. Null is allowed.
void qcFree(void* memory, size_t size);

/// A growing array. All zero is an empty one; it keeps its memory between steps.
typedef struct qcArray
{
    void* data;
    size_t count;    ///< elements in use
    size_t capacity; ///< bytes
} qcArray;

/// The slow path of qcArray_Reserve.
qcStatus qcArray_Grow(qcArray* array, size_t count, size_t elementSize, const char* purpose);
/// Makes room for `count` elements of `elementSize` bytes; the count stays. qc_statusOutOfMemory leaves it as it was.
static inline qcStatus qcArray_Reserve(qcArray* array, size_t count, size_t elementSize, const char* purpose)
{
    return count <= array->capacity / elementSize ? qc_statusOk : qcArray_Grow(array, count, elementSize, purpose);
}
/// Reserves, then sets the count; new elements are not cleared.
qcStatus qcArray_Resize(qcArray* array, size_t count, size_t elementSize, const char* purpose);
/// Resizes to more elements, the new ones all zero; never to fewer.
qcStatus qcArray_GrowZeroed(qcArray* array, size_t count, size_t elementSize, const char* purpose);
/// Adds copies of the other's elements, which are of the same size. qc_statusOutOfMemory leaves it as it was.
qcStatus qcArray_Append(qcArray* array, const qcArray* other, size_t elementSize, const char* purpose);
/// Frees unused capacity. qc_statusOutOfMemory leaves it as it was.
qcStatus qcArray_Trim(qcArray* array, size_t elementSize, const char* purpose);
void qcArray_Free(qcArray* array);

/// array[i] as a T; no check.
#define QC_AT(T, array, i) (((T*)(array).data)[i])

#endif
