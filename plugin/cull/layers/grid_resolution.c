// Chooses the grid resolution by the mean extent of sampled leaf nodes.
#include "cull/layers/grid_resolution.h"

#include "base/aabb.h"
#include "gl/buffers/vertex_snapshot.h"
#include "scene/float_positions.h"

enum
{
    qc_levels = 1 << 15,
    qc_maxLog2 = 12, ///< of one axis
    qc_cellsOfNodeLog2 = 4,
    qc_maxCellsLog2 = 24 ///< in all: 64 MB
};

// A cell's side, in extents of a node: in smaller cells a node has many entries, in larger ones lists grow long. On
// llvmpipe 2 was best or near it for cloths of 20 K and 250 K, the bunny, the dragon and piles of bunnies; 1 and 3 took
// up to twice as long in the kernels of entries and lists.
static const double s_nodesInCell = 2.0;

static uint32_t FloorLog2(uint32_t x)
{
    uint32_t log2 = 0;
    while (x >> (log2 + 1) != 0)
        log2++;
    return log2;
}

/// A node's extent along the axes of the world, by the first corners of its triangles.
static void FindExtent(const qcBody* body, const uint32_t* inNode, double extent[3])
{
    double lower[3], upper[3];
    qcBounds_Clear(lower, upper);
    for (int k = 0; k < qc_nodeSize; k++)
    {
        double p[3];
        if (inNode[k] == QC_NO_TRIANGLE)
            continue;
        qcBody_GetNewestVertex(body, body->indices[3 * (size_t)inNode[k]], p);
        qcBounds_IncludePoint(p, lower, upper);
    }
    for (int axis = 0; axis < 3; axis++)
        extent[axis] = upper[axis] - lower[axis];
}

/// A node's extent along each axis of the frame, in levels.
static void FindLevels(const qcGpuResidency* residency, const qcStepTriangles* triangles, const qcGridFrame* frame,
                       const uint32_t* bodyOf, uint32_t node, double levels[3])
{
    uint32_t slot = QC_AT(uint32_t, residency->nodeSlot, node);
    const qcBodyResidency* resident = &QC_AT(qcBodyResidency, residency->bodies, slot);
    const qcBody* body = qcStepTriangles_Body(triangles, bodyOf[slot]);
    double extent[3] = {resident->nodeExtent, resident->nodeExtent, resident->nodeExtent};
    // The CPU doesn't have the present positions of a body on the device, nor the directions of its nodes.
    if (!qcVertexSnapshot_IsOnlyCopy(body->snapshot))
        FindExtent(body,
                   &QC_AT(uint32_t, resident->clusters.triangles, (size_t)(node - resident->firstNode) * qc_nodeSize),
                   extent);
    for (int i = 0; i < 3; i++)
        levels[i] = extent[frame->axes[i]] * frame->unit * frame->scale[i] + 2.0 * frame->slack[i];
}

double qcGridResolution_FindNodeExtent(const qcBody* body, const qcClusters* clusters)
{
    size_t nodes = clusters->nodeCount, sampled = nodes < qc_sampleNodes ? nodes : qc_sampleNodes;
    double sum = 0.0;
    for (size_t i = 0; i < sampled; i++)
    {
        double extent[3];
        FindExtent(body, &QC_AT(uint32_t, clusters->triangles, i * nodes / sampled * qc_nodeSize), extent);
        sum += extent[0] + extent[1] + extent[2];
    }
    return sampled != 0 ? sum / (3.0 * (double)sampled) : 0.0;
}

/// The axis with most cells: the depth, or, unless `onlyDepth`, a side of the image.
static int FinestAxis(const uint32_t cellsLog2[3], bool onlyDepth)
{
    int finest = 2;
    for (int i = 0; i < 2 && !onlyDepth; i++)
        finest = cellsLog2[i] > cellsLog2[finest] ? i : finest;
    return finest;
}

/// Samples all nodes in a new scene or frame, otherwise the next few.
static void Sample(const qcGpuResidency* residency, const qcStepTriangles* triangles, const qcGridFrame* frame,
                   const uint32_t* bodyOf, qcGridSamples* samples)
{
    size_t nodes = residency->activeNodes.count, sampled = nodes < qc_sampleNodes ? nodes : qc_sampleNodes;
    bool same = samples->frame == frame->number && samples->nodes == nodes && samples->numbered == triangles->numbered;
    uint32_t count = (uint32_t)sampled;
    if (same && count > qc_samplesOfStep)
        count = qc_samplesOfStep;
    samples->frame = frame->number;
    samples->nodes = nodes;
    samples->numbered = triangles->numbered;
    for (uint32_t i = 0; i < count; i++)
    {
        size_t at = (samples->next + i) % sampled;
        FindLevels(residency, triangles, frame, bodyOf, QC_AT(uint32_t, residency->activeNodes, at * nodes / sampled),
                   samples->levels[at]);
    }
    samples->next = sampled != 0 ? (uint32_t)((samples->next + count) % sampled) : 0;
}

void qcGridResolution_Choose(const qcGpuResidency* residency, const qcStepTriangles* triangles,
                             const qcGridFrame* frame, const uint32_t* bodyOf, uint32_t columns, qcGridSamples* samples,
                             uint32_t cellsLog2[3])
{
    size_t nodes = residency->activeNodes.count, sampled = nodes < qc_sampleNodes ? nodes : qc_sampleNodes;
    double extent[3] = {0.0, 0.0, 0.0};
    Sample(residency, triangles, frame, bodyOf, samples);
    for (size_t i = 0; i < sampled; i++)
        for (int axis = 0; axis < 3; axis++)
            extent[axis] += samples->levels[i][axis];
    for (int i = 0; i < 3; i++)
    {
        double cell = sampled != 0 ? s_nodesInCell * extent[i] / (double)sampled : qc_levels;
        cellsLog2[i] = 0;
        // A thin scene covers few of the levels.
        int axis = frame->axes[i];
        if (cell >= (frame->bounds.upper[axis] - frame->bounds.lower[axis]) * frame->unit * frame->scale[i])
            continue;
        while (cellsLog2[i] < qc_maxLog2 && (double)(qc_levels >> (cellsLog2[i] + 1)) >= cell)
            cellsLog2[i]++;
    }
    if (columns != 0)
        cellsLog2[0] = cellsLog2[1] = FloorLog2(columns);
    // Clearing cells must cost less than the nodes do.
    uint32_t maxLog2 = FloorLog2((uint32_t)nodes + 1) + qc_cellsOfNodeLog2;
    maxLog2 = maxLog2 < qc_maxCellsLog2 ? maxLog2 : qc_maxCellsLog2;
    while (cellsLog2[0] + cellsLog2[1] + cellsLog2[2] > maxLog2 && cellsLog2[FinestAxis(cellsLog2, columns != 0)] != 0)
        cellsLog2[FinestAxis(cellsLog2, columns != 0)]--;
}
