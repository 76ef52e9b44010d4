// GPU residency: the bodies of `layers` on the device, and the uploads of a step.
#ifndef QC_CULL_LAYERS_GPU_RESIDENCY_H
#define QC_CULL_LAYERS_GPU_RESIDENCY_H

#include "cull/layers/frame.h"
#include "gl/layers/layers_gpu.h"
#include "mesh/clusters.h"
#include "scene/step_triangles.h"

/// A body on the device.
typedef struct qcBodyResidency
{
    uint32_t generation; ///< of the body that the clusters belong to; 0: none
    qcClusters clusters;
    double nodeExtent; ///< of a leaf node along an axis: the mean over nodes and axes when the clusters were built
    bool assigned;     ///< to ranges of the device's buffers, which begin here
    uint32_t firstVertex, firstNode, firstLink, firstTable;
    bool transformed;      ///< by the device; otherwise its vertices are uploaded in world space
    double center[3];      ///< local: origin of qc_layersLocals
    int exponent;          ///< their unit is 2^exponent
    uint64_t moved, frame; ///< qcBody::moved and the frame of the device's vertices; frame 0: nothing is uploaded
    bool changed;          ///< in this step: its boxes are computed anew
} qcBodyResidency;

typedef struct qcGpuResidency
{
    bool imageOnly;                       ///< the device makes the image alone; set before the first step
    bool sharesVertices;                  ///< see qcLayers_SharesVertices; likewise
    qcArray bodies;                       ///< of qcBodyResidency, by slot
    size_t capacity[qc_layersInputCount]; ///< elements of the device's buffers
    size_t used[qc_layersInputCount];     ///< elements assigned to bodies, removed ones included
    uint32_t freedNodes;                  ///< assigned leaf nodes of removed bodies
    qcArray nodeSlot;                     ///< uint32_t: slot of the body of a leaf node
    qcArray corners;                      ///< of qcCorners, by triangle slot; with imageOnly
    uint32_t changedNodes;                ///< number of leaf nodes of changed bodies, which come first in activeNodes
    //  Data of the step and its uploads, valid until the step has run.
    qcArray locals, triangles, nodes, links;
    qcArray table;        ///< of qcLayersBody, by slot
    qcArray activeNodes;  ///< uint32_t
    qcArray chunks;       ///< of qcLayersChunk
    qcArray sourceChunks; ///< of qcLayersChunk: those of the sources, the last of `chunks`
    qcArray sources;      ///< of qcLayersSource
    qcArray vertexJobs;   ///< of qcVertexJob
    size_t floatCount;    ///< of all chunks
    size_t vertexCount;   ///< of all vertex jobs that write vertices
    qcArray uploads;      ///< of qcLayersUpload
} qcGpuResidency;

/// New vertices of a body, which the processor writes.
typedef struct qcVertexJob
{
    uint32_t body;        ///< of the step
    uint32_t firstVertex; ///< in qcLayersMemory::vertices, where these are shared
    size_t at;            ///< otherwise: in qcLayersMemory::floats
    bool inWorld;         ///< the device applies the frame: positions are floats
} qcVertexJob;

/// The bodies of a step. By body: flags of those that take part and of those with self-collision; four words each, the
/// box of levels outside of which the body can't overlap a partner (qcLayers_PackBox).
typedef struct qcResidencyJob
{
    const qcStepTriangles* triangles;
    const qcGridFrame* frame;
    const uint8_t *takesPart, *hasSelfPairs;
    const uint32_t* partnerBoxes;
    uint32_t threads;
} qcResidencyJob;

/// Plans the uploads of a step.
qcStatus qcGpuResidency_Prepare(const qcResidencyJob* job, qcGpuResidency* residency);

/// Fills the device's step: capacity, uploads, bodies, chunks, nodes and frame.
void qcGpuResidency_FillStep(const qcGpuResidency* residency, const qcGridFrame* frame, qcLayersStep* step);

/// Writes the step's new vertices where the device reads them: each is written once.
void qcGpuResidency_WriteVertices(const qcResidencyJob* job, const qcGpuResidency* residency,
                                  const qcLayersMemory* memory);

/// The index in its body of the triangle at a slot of the device, and the body's slot.
static inline uint32_t qcGpuResidency_TriangleAt(const qcGpuResidency* residency, uint32_t triangleSlot, uint32_t* slot)
{
    uint32_t node = triangleSlot / qc_nodeSize;
    *slot = QC_AT(uint32_t, residency->nodeSlot, node);
    const qcBodyResidency* body = &QC_AT(qcBodyResidency, residency->bodies, *slot);
    return QC_AT(uint32_t, body->clusters.triangles, triangleSlot - body->firstNode * qc_nodeSize);
}

/// The clusters of a body that took part in the last step.
static inline qcClusters* qcGpuResidency_Clusters(const qcGpuResidency* residency, uint32_t slot)
{
    return &QC_AT(qcBodyResidency, residency->bodies, slot).clusters;
}

/// After a failure: the next step assigns ranges and uploads everything again.
void qcGpuResidency_Forget(qcGpuResidency* residency);
void qcGpuResidency_Free(qcGpuResidency* residency);

#endif
