// The grid resolution of `layers`: columns and rows of the image, and slices of depth.
#ifndef QC_CULL_LAYERS_GRID_RESOLUTION_H
#define QC_CULL_LAYERS_GRID_RESOLUTION_H

#include "cull/layers/gpu_residency.h"

enum
{
    // Sampled leaf nodes; of each the first corner of every triangle. All of them take 70 microseconds if nothing is
    // cached, so that a steady step samples a few anew.
    qc_sampleNodes = 32,
    qc_samplesOfStep = 4
};

/// Retained between steps; zeroed before the first.
typedef struct qcGridSamples
{
    uint64_t frame, numbered; ///< qcGridFrame::number and qcStepTriangles::numbered of the samples
    size_t nodes;             ///< active ones
    uint32_t next;            ///< the sample that is taken anew next
    double levels[qc_sampleNodes][3];
} qcGridSamples;

/// Chooses the logarithms (to base 2) of the numbers of columns, rows and slices, for the active leaf nodes of the
/// step: cells of about two nodes' size, by a sample of the nodes. `columns`: the number of columns and rows, rounded
/// down to a power of two; 0: chosen. `bodyOf`: by slot, the body of the step. O(1).
void qcGridResolution_Choose(const qcGpuResidency* residency, const qcStepTriangles* triangles,
                             const qcGridFrame* frame, const uint32_t* bodyOf, uint32_t columns, qcGridSamples* samples,
                             uint32_t cellsLog2[3]);

/// The extent of a leaf node along an axis, in scene units: the mean over sampled nodes and the three axes.
double qcGridResolution_FindNodeExtent(const qcBody* body, const qcClusters* clusters);

#endif
