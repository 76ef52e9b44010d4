// The device's part of `layers`: from vertices to pairs of triangles that may be within reach of each other.
// The image is a grid of pixels over two axes, each cut into slices of depth; each such cell has a list of the nodes
// (64 triangles) that cover it, with their intervals in all axes. Nodes that share a cell and overlap are taken apart
// into clusters (8) and triangles: by the device or, where that is the processor itself, by cull/layers/cpu_refine.h.
#ifndef QC_GL_LAYERS_LAYERS_GPU_H
#define QC_GL_LAYERS_LAYERS_GPU_H

#include "base/memory.h"
#include "quickcullide/device.h"
#include "kernels/triangle_kernels.h"

/// What stays on the device; elements are 16 bytes where nothing else is said.
typedef enum qcLayersBuffer
{
    /// Four floats: the vertex in the frame, within [0, 1], each coordinate within `pointError` of the true one; the
    /// fourth unused.
    qc_layersVertices,
    /// Bits of three floats: a rigid body's vertex about its centre, within [-1, 1]; then the body's place.
    qc_layersLocals,
    /// A triangle's place holds three places of vertices; QC_NO_TRIANGLE first: none.
    qc_layersTriangles,
    /// A node's place: the body's place, its first link, the end of its links.
    qc_layersNodes,
    /// 8 bytes: a node's place that is not below, a table's place.
    qc_layersLinks,
    /// 8 bytes: words of packed tables, qcClusters::tables.
    qc_layersTables,
    /// qc_layersBodyTexels of them a body: see qcLayersBody.
    qc_layersBodies,
    /// 4 bytes: nodes that take part in the step, changed ones first.
    qc_layersActiveNodes,
    /// 4 bytes: vertices of rigid bodies that moved, 64 a chunk.
    qc_layersChunks,
    qc_layersInputCount
} qcLayersBuffer;

enum
{
    qc_layersLevels = 32767, ///< the highest level; the least is 1, below all of which an empty box ends
    qc_layersBodyTexels = 5,
    qc_layersIsMoving = 1,
    qc_layersMeetsItself = 2
};

typedef struct qcLayersBody
{
    uint32_t group, mask, flags, owner;
    uint32_t interest[4]; ///< a box of levels, see qcLayers_PackBox: what lies outside is left out
    float transform[3][4];
} qcLayersBody;

typedef struct qcLayersUpload
{
    qcLayersBuffer buffer;
    size_t first, count; ///< elements
    const void* data;
} qcLayersUpload;

/// The parts of a step that are timed, in the order of the work.
typedef enum qcLayersPart
{
    qc_partPrepare,  ///< on the calling thread: which bodies take part, what is uploaded
    qc_partHandOver, ///< to the device's thread
    qc_partUpload,
    qc_partVertices,
    qc_partBoxes,
    qc_partClear, ///< of lists
    qc_partNodes,
    qc_partNodePairs,
    qc_partClusterPairs,
    qc_partTrianglePairs,
    qc_partFilter,
    qc_partCounters, ///< the wait for the device, until its counters are read
    qc_partResults,  ///< its answer is read
    qc_partHandBack, ///< GL's state is reset, errors are read, back to the calling thread
    qc_partRefine,   ///< on the calling thread: from the answer to pairs of triangles
    qc_layersPartCount
} qcLayersPart;

typedef struct qcLayersStep
{
    /// Elements of each input buffer; where it is more than there are, the buffer grows and loses what it held.
    size_t capacity[qc_layersInputCount];
    const qcLayersUpload* uploads;
    size_t uploadCount;
    uint32_t chunkCount;                ///< rigid vertices to transform first
    uint32_t changedNodes, activeNodes; ///< of qc_layersActiveNodes
    float scale[3];                     ///< levels = coordinate * scale
    float slack[4];          ///< levels by which a box is too small otherwise; the fourth: along the diagonal
    uint32_t cellsLog2[3];   ///< columns, rows and slices of the image: 0..12 each, 0..24 in all
    float pointError, reach; ///< in the frame
    bool testNeighbours;
    bool timed;
} qcLayersStep;

#define QC_NO_ENTRY UINT32_MAX

/// A node in one cell's list.
typedef struct qcLayersEntry
{
    uint32_t node, next, cell, body; ///< places; `next`: of the next entry in the list, or QC_NO_ENTRY
} qcLayersEntry;

/// All that covers cells, and what it is to be taken apart by; all but entries by place.
typedef struct qcLayersImage
{
    const qcLayersEntry* entries;
    uint32_t entryCount;
    const uint32_t (*nodeBoxes)[4];           ///< as qcLayers_PackBox
    const qcBox8 *clusterGroups, *nodeGroups; ///< boxes in levels: of triangles, of clusters
    const qcPoint* vertices;                  ///< in the frame
} qcLayersImage;

typedef struct qcLayersAnswer
{
    const uint32_t* pairs; ///< two places of triangles each, in no order; valid until the next step
    size_t pairCount;
    qcLayersImage image; ///< in place of pairs, if that is all; valid as long
    uint64_t entries;
    uint64_t trianglePairs; ///< whose boxes overlap, before the separating axes; 0 beside an image
    uint64_t skippedNodes;  ///< outside their body's interest
    uint32_t reruns;
    uint64_t uploadedBytes, deviceBytes;
    /// By qcLayersPart, as in qcGlTimers; null unless the step is timed. Valid until the next step.
    const double *threadMs, *deviceMs;
} qcLayersAnswer;

typedef struct qcLayers qcLayers;

/// With `imageOnly` the image is the answer: links and tables of bodies, and their rules, are not read.
/// qc_statusDevice on a device without compute shaders.
qcStatus qcLayers_Create(qcDevice* device, bool imageOnly, qcLayers** layers);
/// Whether its GL objects exist: false after the device was reopened, and for null.
bool qcLayers_IsAlive(const qcLayers* layers);
/// Null is allowed.
void qcLayers_Destroy(qcLayers* layers);
/// qc_statusDevice where the device's buffers can't hold the scene, or the device fails.
qcStatus qcLayers_Run(qcLayers* layers, const qcLayersStep* step, qcLayersAnswer* answer);

/// The cell of a box's lower ends.
static inline uint32_t qcLayers_CellAt(const uint32_t at[3], const uint32_t cellsLog2[3])
{
    return (at[2] << cellsLog2[1] | at[1]) << cellsLog2[0] | at[0];
}

/// Levels 1..qc_layersLevels, or 0: x, y, depth, (x + y) / 2.
static inline void qcLayers_PackBox(const uint32_t lower[4], const uint32_t upper[4], uint32_t box[4])
{
    box[0] = lower[0] | lower[1] << 16;
    box[1] = lower[2] | lower[3] << 16;
    box[2] = upper[0] | upper[1] << 16 | 0x80008000u;
    box[3] = upper[2] | upper[3] << 16 | 0x80008000u;
}

#endif
