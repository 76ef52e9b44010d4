// Clamped levels: plugin/docs/proofs/triangle_bvh.md.
#include "sweep/bvh/bvh_lattice.h"

#include "mesh/triangle_sample.h"

#include <math.h>
#include <string.h>

enum
{
    // Beyond these a power of two, or its inverse, or a product with one, may leave the range of double.
    qc_maxExponent = 960
};

/// Takes triangles from slots at equal distances.
static void TakeSample(const qcTriangleBvh* bvh, const qcVertexSource* source, qcTriangleSample* sample)
{
    const size_t slots = bvh->corners.count;
    const uint32_t count = qcTriangleSample_Count((uint32_t)slots);
    sample->count = 0;
    for (uint32_t i = 0; i < count; i++)
    {
        const uint32_t* vertex = QC_AT(qcCorners, bvh->corners, (2 * i + 1) * slots / (2 * count)).vertex;
        if (vertex[0] == bvh->vertexCount)
            continue;
        for (int c = 0; c < 3; c++)
            for (size_t axis = 0; axis < 3; axis++)
            {
                size_t at = 3 * (size_t)source->vertexOf[vertex[c]] + axis;
                sample->corners[sample->count][c][axis] =
                    source->floats != NULL ? (double)source->floats[at] : source->doubles[at];
            }
        sample->count++;
    }
}

double qcBvhLattice_TriangleSize(const qcTriangleBvh* bvh, const qcVertexSource* source)
{
    qcTriangleSample sample;
    TakeSample(bvh, source, &sample);
    return qcTriangleSample_MedianSize(&sample);
}

/// False: the box is too large for a lattice.
static bool SpanBox(qcLatticeTransform* lattice, const double lower[3], const double upper[3], double margin,
                    double extent[3])
{
    double widest = 0.0;
    for (int axis = 0; axis < 3; axis++)
    {
        lattice->origin[axis] = lower[axis] - margin;
        lattice->margin[axis] = margin;
        // In the order of the kernels, so that it rounds like them.
        extent[axis] = upper[axis] + margin + margin - lattice->origin[axis];
        widest = fmax(widest, extent[axis]);
    }
    int exponent = 0;
    if (widest > 0.0)
        frexp(widest, &exponent);
    if (!isfinite(widest) || exponent > qc_maxExponent)
        return false;
    exponent = exponent < -qc_maxExponent ? -qc_maxExponent : exponent;
    for (int axis = 0; axis < 3; axis++)
    {
        lattice->unit[axis] = ldexp(1.0, -exponent);
        // Along the thin axis of a flat body levels are no finer than the precision of coordinates.
        double levels = qc_lastLevel * (1.0 - 0x1p-50) / fmax(extent[axis], widest * 0x1p-30);
        lattice->scale[axis] = widest > 0.0 ? fmin(levels, 0x1p1000) : 1.0;
    }
    return true;
}

bool qcBvhLattice_Choose(const qcTriangleBvh* bvh, const qcVertexSource* source, const double lower[3],
                         const double upper[3], double margin, qcBvhFit* fit)
{
    double low[3], high[3];
    memcpy(low, lower, sizeof low);
    memcpy(high, upper, sizeof high);
    fit->lattice = (qcLatticeTransform){.hasOutliers = false};
    if (qcBounds_AreWide(lower, upper, bvh->triangleSize))
    {
        qcTriangleSample sample;
        TakeSample(bvh, source, &sample);
        fit->lattice.hasOutliers = qcTriangleSample_Trim(&sample, low, high);
    }
    fit->isCoarse =
        bvh->triangleSize > 0.0 && (fit->lattice.hasOutliers || qcBounds_AreWide(low, high, bvh->triangleSize));
    return SpanBox(&fit->lattice, low, high, margin, fit->latticeExtent);
}

void qcBvhLattice_GetBox(const qcLatticeTransform* lattice, double lower[3], double upper[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = lattice->origin[axis] - 1.0 / lattice->unit[axis];
        upper[axis] = lattice->origin[axis] + 1.0 / lattice->unit[axis];
    }
}
