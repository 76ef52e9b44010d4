// The choice of a fit's lattice and frame: around all vertices, or around most where outliers would make it too coarse
// (mesh/triangle_sample.h).
#ifndef QC_SWEEP_BVH_BVH_LATTICE_H
#define QC_SWEEP_BVH_BVH_LATTICE_H

#include "sweep/bvh/triangle_bvh.h"

/// The median size of the triangles at these positions. 0: unknown.
double qcBvhLattice_TriangleSize(const qcTriangleBvh* bvh, const qcVertexSource* source);

/// Chooses the fit's lattice within the box around all vertices. False: no lattice suits the body (too large for
/// doubles). O(1).
bool qcBvhLattice_Choose(const qcTriangleBvh* bvh, const qcVertexSource* source, const double lower[3],
                         const double upper[3], double margin, qcBvhFit* fit);

/// The box of a lattice with outliers: coordinates in the frame up to 1, or down to -1.
void qcBvhLattice_GetBox(const qcLatticeTransform* lattice, double lower[3], double upper[3]);

/// True if the triangle has a vertex outside the frame of the points: errors of its coordinates are larger than
/// qcBvhFit::pointError.
static inline bool qcBvhFit_IsOutlier(const qcBvhFit* fit, const qcCorners* corners)
{
    bool isWithin = true;
    for (int c = 0; c < 3; c++)
        for (int axis = 0; axis < 3; axis++)
            isWithin &= fabsf(QC_AT(qcPoint, fit->points, corners->vertex[c]).x[axis]) <= 1.0f;
    return !isWithin;
}

#endif
