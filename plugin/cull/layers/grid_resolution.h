// The image of `layers`: how fine its pixels are, and into how many slices of depth their lists are cut.
#ifndef QC_CULL_LAYERS_GRID_RESOLUTION_H
#define QC_CULL_LAYERS_GRID_RESOLUTION_H

#include "cull/layers/gpu_residency.h"

/// Logarithms (to base 2) of the numbers of columns, rows and slices for the nodes that take part in the step: cells of
/// about two nodes' size, as a few of the nodes show it. `columns`: 0, or how many columns and rows there are to be,
/// rounded down to a power of two. `numberOf`: by slot, the body of the step.
void qcLayersImage_Choose(const qcLayersBodies* bodies, const qcStepTriangles* triangles, const qcLayersFrame* frame,
                          const uint32_t* numberOf, uint32_t columns, uint32_t cellsLog2[3]);

#endif
