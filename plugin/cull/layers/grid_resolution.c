#include "cull/layers/grid_resolution.h"

#include <float.h>

enum
{
    /// Nodes that are looked at, of a step; and of each the first corner of every triangle: 10 microseconds in all.
    qc_sampleNodes = 32,
    qc_levels = 1 << 15,
    qc_mostLog2 = 12, ///< of one axis
    qc_cellsOfNodeLog2 = 4,
    qc_mostCellsLog2 = 24 ///< in all: 64 MB
};

// A cell's side, in extents of a node: with smaller ones a node has many entries, with larger ones lists grow long. On
// llvmpipe 2 was best or near it for cloths of 20 K and 250 K, the bunny, the dragon and piles of bunnies; 1 and 3 took
// up to twice as long in their two kernels.
static const double s_nodesInCell = 2.0;

static uint32_t FloorLog2(uint32_t x)
{
    uint32_t log2 = 0;
    while (x >> (log2 + 1) != 0)
        log2++;
    return log2;
}

/// Adds a node's extent along each axis of the frame, in levels.
static void AddExtent(const qcLayersBodies* bodies, const qcStepTriangles* triangles, const qcLayersFrame* frame,
                      const uint32_t* numberOf, uint32_t node, double extent[3])
{
    uint32_t slot = QC_AT(uint32_t, bodies->nodeSlot, node);
    const qcLayersPlace* place = &QC_AT(qcLayersPlace, bodies->places, slot);
    const qcBody* body = qcStepTriangles_Body(triangles, numberOf[slot]);
    const uint32_t* inNode =
        &QC_AT(uint32_t, place->clusters.triangles, (size_t)(node - place->firstNode) * qc_nodeSize);
    double lower[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, upper[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    for (int k = 0; k < qc_nodeSize; k++)
    {
        double p[3];
        if (inNode[k] == QC_NO_TRIANGLE)
            continue;
        qcBody_GetVertex(body, body->indices[3 * (size_t)inNode[k]], p);
        for (int axis = 0; axis < 3; axis++)
        {
            lower[axis] = p[axis] < lower[axis] ? p[axis] : lower[axis];
            upper[axis] = p[axis] > upper[axis] ? p[axis] : upper[axis];
        }
    }
    for (int i = 0; i < 3; i++)
    {
        int axis = frame->axes[i];
        extent[i] += (upper[axis] - lower[axis]) * frame->unit * frame->scale[i] + 2.0 * frame->slack[i];
    }
}
/// The axis with most cells; of the depth and, where they may be chosen, of the image's sides.
static int FinestAxis(const uint32_t cellsLog2[3], bool onlyDepth)
{
    int finest = 2;
    for (int i = 0; i < 2 && !onlyDepth; i++)
        finest = cellsLog2[i] > cellsLog2[finest] ? i : finest;
    return finest;
}

void qcLayersImage_Choose(const qcLayersBodies* bodies, const qcStepTriangles* triangles, const qcLayersFrame* frame,
                          const uint32_t* numberOf, uint32_t columns, uint32_t cellsLog2[3])
{
    size_t nodes = bodies->activeNodes.count, looked = nodes < qc_sampleNodes ? nodes : qc_sampleNodes;
    double extent[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < looked; i++)
        AddExtent(bodies, triangles, frame, numberOf, QC_AT(uint32_t, bodies->activeNodes, i * nodes / looked), extent);
    for (int i = 0; i < 3; i++)
    {
        double cell = looked != 0 ? s_nodesInCell * extent[i] / (double)looked : qc_levels;
        cellsLog2[i] = 0;
        // A thin scene lies within a few of the levels.
        int axis = frame->axes[i];
        if (cell >= (frame->view.upper[axis] - frame->view.lower[axis]) * frame->unit * frame->scale[i])
            continue;
        while (cellsLog2[i] < qc_mostLog2 && (double)(qc_levels >> (cellsLog2[i] + 1)) >= cell)
            cellsLog2[i]++;
    }
    if (columns != 0)
        cellsLog2[0] = cellsLog2[1] = FloorLog2(columns);
    // Clearing is to cost less than the nodes do.
    uint32_t most = FloorLog2((uint32_t)nodes + 1) + qc_cellsOfNodeLog2;
    most = most < qc_mostCellsLog2 ? most : qc_mostCellsLog2;
    while (cellsLog2[0] + cellsLog2[1] + cellsLog2[2] > most && cellsLog2[FinestAxis(cellsLog2, columns != 0)] != 0)
        cellsLog2[FinestAxis(cellsLog2, columns != 0)]--;
}
