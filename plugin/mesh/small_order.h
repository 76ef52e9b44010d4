// The cluster order of few triangles: halved like many, in 16-bit coordinates.
#ifndef QC_MESH_SMALL_ORDER_H
#define QC_MESH_SMALL_ORDER_H

#include <stddef.h>
#include <stdint.h>

enum
{
    // Their coordinates along one axis take 8 KB. With 2048 or 32768 the order of 1 M triangles takes as long.
    qc_maxSmallOrder = 4096
};

typedef struct qcCentroid
{
    float at[3]; ///< 0 .. 1
    uint32_t triangle;
} qcCentroid;

/// Where `count` triangles are cut in two: at about a half, at a multiple of the largest size * 8^k that fits, so that
/// the triangles of eight nodes, and of eight times eight, lie together too. For more than `size` triangles.
static inline uint32_t qcSmallOrder_CutAt(uint32_t count, uint32_t size)
{
    uint32_t whole = size;
    while (whole < (count + 7) / 8)
        whole *= 8;
    return ((count - 1) / whole + 2) / 2 * whole;
}

/// Compiled once for each instruction set and chosen at run time; the order does not depend on it.
typedef struct qcOrderKernels
{
    /// Lists 1 .. qc_maxSmallOrder triangles by nodes and clusters. `memory` has room for as many centroids.
    void (*makeSmallOrder)(const qcCentroid* centroids, uint32_t count, void* memory, uint32_t* triangles);
} qcOrderKernels;

extern const qcOrderKernels qcOrderKernels_scalar;
#ifdef QC_KERNELS_X86
extern const qcOrderKernels qcOrderKernels_avx2, qcOrderKernels_avx512;
#endif

/// The best that this machine runs. The environment's QC_KERNELS (plain, avx2, avx512) names another.
const qcOrderKernels* qcOrderKernels_Get(void);
/// Null: there is no i-th one, or this machine doesn't run it.
const qcOrderKernels* qcOrderKernels_Nth(size_t i);

#endif
