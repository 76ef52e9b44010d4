// What `layers` keeps of each body on the device, and what has to be uploaded when bodies come, go or move.
#ifndef QC_CULL_LAYERS_GPU_RESIDENCY_H
#define QC_CULL_LAYERS_GPU_RESIDENCY_H

#include "mesh/clusters.h"
#include "gl/layers/layers_gpu.h"
#include "cull/layers/frame.h"
#include "scene/step_triangles.h"

/// A body's place in the buffers; bodies are placed by slot.
typedef struct qcLayersPlace
{
    uint32_t generation; ///< of the body whose clusters these are; 0: none
    qcClusters clusters;
    bool placed; ///< what follows has been given out
    uint32_t firstVertex, firstNode, firstLink, firstTable;
    bool transformed;      ///< by the device; otherwise its vertices are uploaded
    double center[3];      ///< local: what qc_layersLocals are about
    int exponent;          ///< and their unit
    uint64_t moved, frame; ///< what the device's vertices belong to; frame 0: the device has nothing of the body
    bool changed;          ///< in this step: boxes are to be made anew
} qcLayersPlace;

typedef struct qcLayersBodies
{
    bool imageOnly;                                    ///< what the device finds; to be set before all else
    qcArray places;                                    ///< of qcLayersPlace, by slot
    size_t capacity[qc_layersInputCount];              ///< elements that the device holds
    size_t used[qc_layersInputCount];                  ///< elements given to bodies, also to those that are gone
    uint32_t goneNodes;                                ///< of these
    qcArray nodeSlot;                                  ///< uint32_t: slot of a node's body
    qcArray corners;                                   ///< of qcCorners, by place, for an image only
    qcArray vertices, locals, triangles, nodes, links; ///< what is uploaded; kept until the step has run
    qcArray bodies, sentBodies;                        ///< of qcLayersBody, by slot
    qcArray activeNodes, chunks;                       ///< uint32_t
    qcArray uploads;                                   ///< of qcLayersUpload
    uint32_t changedNodes;
} qcLayersBodies;

/// Plans the uploads of a step for the bodies that take part. `takesPart`: a flag a body of the step; `interests`: four
/// words each, a box of levels outside of which the body meets nothing.
qcStatus qcLayersBodies_Prepare(qcLayersBodies* bodies, const qcStepTriangles* triangles, const qcLayersFrame* frame,
                                const uint8_t* takesPart, const uint32_t* interests, const uint8_t* meetsItself,
                                uint32_t threads);

/// Fills what the step takes from here: capacity, uploads, chunks and nodes.
void qcLayersBodies_FillStep(const qcLayersBodies* bodies, qcLayersStep* step);

/// The triangle at a place, and its body's slot.
static inline uint32_t qcLayersBodies_TriangleAt(const qcLayersBodies* bodies, uint32_t place, uint32_t* slot)
{
    uint32_t node = place / qc_nodeSize;
    *slot = QC_AT(uint32_t, bodies->nodeSlot, node);
    const qcLayersPlace* at = &QC_AT(qcLayersPlace, bodies->places, *slot);
    return QC_AT(uint32_t, at->clusters.triangles, place - at->firstNode * qc_nodeSize);
}

/// The clusters of a body that took part in the last step.
static inline qcClusters* qcLayersBodies_Clusters(const qcLayersBodies* bodies, uint32_t slot)
{
    return &QC_AT(qcLayersPlace, bodies->places, slot).clusters;
}

/// After a failure: places are given out and everything is uploaded again in the next step.
void qcLayersBodies_Forget(qcLayersBodies* bodies);
void qcLayersBodies_Free(qcLayersBodies* bodies);

#endif
