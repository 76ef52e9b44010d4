// Pairs of triangles of one surface that share a vertex, for contacts between their other features: those that are not
// known to be without.
#ifndef QC_PLUGIN_SURFACE_NEIGHBOURS_H
#define QC_PLUGIN_SURFACE_NEIGHBOURS_H

#include "surface.h"

typedef struct qcSurfaceNeighboursJob
{
    const qcSurfaceKernels* kernels;
    const qcSurface* surface; ///< fitted with the margin; what is flat is known
    uint32_t first;           ///< rank of the body's first triangle
    uint32_t threads;
} qcSurfaceNeighboursJob;

/// Memory that is kept between steps.
typedef struct qcSurfaceNeighbours
{
    qcArray sinks; ///< by worker
} qcSurfaceNeighbours;

/// Adds the keys (lower rank << 32 | higher), in no order: at least all pairs with features (vertices, edges,
/// triangles) that have no vertex in common and are within the surface's margin of each other. O(pairs of neighbours).
qcStatus qcSurfaceNeighbours_Add(qcSurfaceNeighbours* neighbours, const qcSurfaceNeighboursJob* job, qcArray* keys);
void qcSurfaceNeighbours_Free(qcSurfaceNeighbours* neighbours);

#endif
