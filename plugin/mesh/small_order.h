// The cluster order of few triangles: halved like many, in 16-bit coordinates.
#ifndef QC_MESH_SMALL_ORDER_H
#define QC_MESH_SMALL_ORDER_H

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

/// Lists 1 .. qc_maxSmallOrder triangles by nodes and clusters. `memory` has room for as many centroids.
void qcSmallOrder_Make(const qcCentroid* centroids, uint32_t count, void* memory, uint32_t* triangles);

#endif
