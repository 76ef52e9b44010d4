// Counted allocation. C17's aligned_alloc is the default heap.
#define _DEFAULT_SOURCE // madvise
#include "base/memory.h"

#include "base/status.h"

#include <assert.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#ifdef __linux__
#include <sys/mman.h>
#endif

enum
{
    // A cache line, and the widest vector register there is.
    qc_alignment = 64,
    qc_hugePage = 1 << 21
};

static atomic_size_t s_byteCount;

/// Huge pages make the first use of a large array several times as fast. The advice may be ignored.
static void AdviseHugePages(void* memory, size_t size)
{
#ifdef __linux__
    uintptr_t first = ((uintptr_t)memory + qc_hugePage - 1) / qc_hugePage * qc_hugePage;
    uintptr_t end = ((uintptr_t)memory + size) / qc_hugePage * qc_hugePage;
    if (memory != NULL && first < end)
        (void)madvise((void*)first, end - first, MADV_HUGEPAGE);
#else
    (void)memory;
    (void)size;
#endif
}

static void* DefaultAllocate(size_t size, void* context)
{
    (void)context;
    // aligned_alloc takes multiples of the alignment only.
    size_t rounded = (size + qc_alignment - 1) & ~(size_t)(qc_alignment - 1);
    void* memory = rounded < size ? NULL : aligned_alloc(qc_alignment, rounded);
    AdviseHugePages(memory, rounded);
    return memory;
}

static void DefaultFree(void* memory, size_t size, void* context)
{
    (void)size;
    (void)context;
    free(memory);
}

static qcAllocateFunction* s_allocate = DefaultAllocate;
static qcFreeFunction* s_free = DefaultFree;
static void* s_context;

qcStatus qcSetAllocator(qcAllocateFunction* allocate, qcFreeFunction* release, void* context)
{
    if ((allocate == NULL) != (release == NULL))
        return qcFail(qc_statusBadInput, "qcSetAllocator: allocate and release must both be given, or neither");
    if (qcGetByteCount() != 0)
        return qcFail(qc_statusBadInput, "qcSetAllocator: %zu bytes are still held from the old allocator",
                      qcGetByteCount());
    s_allocate = allocate != NULL ? allocate : DefaultAllocate;
    s_free = release != NULL ? release : DefaultFree;
    s_context = context;
    return qc_statusOk;
}

size_t qcGetByteCount(void)
{
    return atomic_load(&s_byteCount);
}

void* qcAllocate(size_t size)
{
    if (size == 0)
        return NULL;
    void* memory = s_allocate(size, s_context);
    if (memory != NULL)
        atomic_fetch_add(&s_byteCount, size);
    return memory;
}

void* qcAllocateZeroed(size_t size)
{
    void* memory = qcAllocate(size);
    if (memory != NULL)
        memset(memory, 0, size);
    return memory;
}

void qcFree(void* memory, size_t size)
{
    if (memory == NULL)
        return;
    assert(atomic_load(&s_byteCount) >= size);
    atomic_fetch_sub(&s_byteCount, size);
    s_free(memory, size, s_context);
}

/// Bytes for an array that needs more than its capacity: as many, or half as many again as it has, so that n pushes
/// cost O(n). Small blocks are powers of two: many bodies of a few triangles take little memory, and freed blocks fit
/// others. With blocks of 64 bytes and their multiples the steps of 10 000 such bodies took a fifth longer.
static size_t GrownCapacity(size_t capacity, size_t needed)
{
    size_t grown = capacity + capacity / 2, power = 128;
    grown = grown < needed ? needed : grown;
    while (power < grown && power < 4096)
        power *= 2;
    return grown < power ? power : grown;
}

/// Moves the elements to a block of another size, large enough for them.
static qcStatus MoveTo(qcArray* array, size_t capacity, size_t elementSize, const char* purpose)
{
    void* data = qcAllocate(capacity);
    if (data == NULL)
        return qcFailMemory(capacity, purpose);
    if (array->count != 0)
        memcpy(data, array->data, array->count * elementSize);
    qcFree(array->data, array->capacity);
    array->data = data;
    array->capacity = capacity;
    return qc_statusOk;
}

qcStatus qcArray_Grow(qcArray* array, size_t count, size_t elementSize, const char* purpose)
{
    if (count > SIZE_MAX / 2 / elementSize)
        return qcFailMemory(SIZE_MAX, purpose);
    size_t needed = count * elementSize;
    // The element size of an array never changes.
    assert(array->count * elementSize <= array->capacity);
    return MoveTo(array, GrownCapacity(array->capacity, needed), elementSize, purpose);
}

qcStatus qcArray_Trim(qcArray* array, size_t elementSize, const char* purpose)
{
    size_t needed = array->count * elementSize;
    return needed == 0 || needed == array->capacity ? qc_statusOk : MoveTo(array, needed, elementSize, purpose);
}

qcStatus qcArray_Resize(qcArray* array, size_t count, size_t elementSize, const char* purpose)
{
    QC_TRY(qcArray_Reserve(array, count, elementSize, purpose));
    array->count = count;
    return qc_statusOk;
}

qcStatus qcArray_GrowZeroed(qcArray* array, size_t count, size_t elementSize, const char* purpose)
{
    size_t old = array->count;
    if (count <= old)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(array, count, elementSize, purpose));
    memset((char*)array->data + old * elementSize, 0, (count - old) * elementSize);
    return qc_statusOk;
}

qcStatus qcArray_Append(qcArray* array, const qcArray* other, size_t elementSize, const char* purpose)
{
    QC_TRY(qcArray_Reserve(array, array->count + other->count, elementSize, purpose));
    // memcpy takes no null pointers, even for no bytes.
    if (other->count != 0)
        memcpy((char*)array->data + array->count * elementSize, other->data, other->count * elementSize);
    array->count += other->count;
    return qc_statusOk;
}

void qcArray_Free(qcArray* array)
{
    qcFree(array->data, array->capacity);
    *array = (qcArray){0};
}
