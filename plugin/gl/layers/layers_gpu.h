// The device's part of `layers`: from vertices to pairs of triangles that may be within the query distance.
// A GPU compares the boxes of all nodes (64 triangles) in tiles, refines nodes that overlap to clusters (8) and
// triangles, and tests pairs of these. Where the device is the processor itself, it makes the image: a grid of pixels
// over two axes, each cut into slices of depth; each cell has a list of the nodes that cover it, and
// cull/layers/cpu_refine.h refines the lists.
#ifndef QC_GL_LAYERS_LAYERS_GPU_H
#define QC_GL_LAYERS_LAYERS_GPU_H

#include "base/memory.h"
#include "quickcullide/device.h"
#include "kernels/triangle_kernels.h"

/// Buffers whose contents stay on the device. Elements are 16 bytes unless stated otherwise.
typedef enum qcLayersBuffer
{
    /// By vertex: four floats, the position in the grid frame, within [0, 1], each coordinate within `pointError` of
    /// the true one; the fourth is unused. Not uploaded: see qcLayersChunk and qcLayersMemory.
    qc_layersVertices,
    /// By vertex of a rigid body: bits of three floats, the position about its centre, within [-1, 1]; the body's slot.
    qc_layersLocals,
    /// By triangle slot: three vertices, the triangle's index in its body; QC_NO_TRIANGLE first: the slot is empty.
    qc_layersTriangles,
    /// By node: the body's slot, its first link, the end of its links.
    qc_layersNodes,
    /// 8 bytes: an adjacent node, not below this one; its pair masks in qc_layersTables.
    qc_layersLinks,
    /// 8 bytes: words of packed pair masks, qcClusters::pairMasks.
    qc_layersTables,
    qc_layersInputCount
} qcLayersBuffer;

enum
{
    qc_layersLevels =
        32767, ///< the highest level; the lowest is 1, so that an empty box, which ends at 0, is below all
    qc_layersChunkSize = 64, ///< vertices
    qc_layersIsMoving = 1,
    qc_layersMeetsItself = 2
};

/// By slot of a body, in each step.
typedef struct qcLayersBody
{
    uint32_t group, mask, flags, owner;
    uint32_t interest[4]; ///< AABB of its partners, in levels (qcLayers_PackBox): nodes outside are skipped
    float transform[3][4];
    uint32_t firstTriangle; ///< of the body, in the step's numbering
} qcLayersBody;

/// What a chunk's vertices are made of.
typedef enum qcLayersChunkKind
{
    qc_chunkRigid,   ///< qc_layersLocals and the body's transform
    qc_chunkWorld,   ///< three floats each, in the world: the device applies the frame
    qc_chunkInFrame, ///< three floats each, in the frame
} qcLayersChunkKind;

/// Up to qc_layersChunkSize vertices that are new in this step. The floats of a vertex lie at word `at` + k * `stride`
/// of the step's floats, or of the buffer of a qcLayersSource.
typedef struct qcLayersChunk
{
    uint32_t first, count; ///< in qc_layersVertices; `first` is a multiple of qc_layersChunkSize
    uint32_t at;
    uint32_t kindAndStride; ///< qcLayersChunkKind | stride << 8
} qcLayersChunk;

/// Chunks whose floats lie in a GL buffer of the device's context, which the caller keeps until the step has ended.
typedef struct qcLayersSource
{
    uint32_t buffer;     ///< name of a GL buffer object; words are counted from its start
    uint32_t chunkCount; ///< consecutive ones, after those of the sources before
} qcLayersSource;

typedef struct qcLayersUpload
{
    qcLayersBuffer buffer;
    size_t first, count; ///< elements
    const void* data;
} qcLayersUpload;

/// The timed parts of a step, in the order of the work.
typedef enum qcLayersPart
{
    qc_partPrepare,  ///< on the calling thread: selects bodies, writes vertices into mapped memory
    qc_partHandOver, ///< from the calling thread to the device's
    qc_partUpload,
    qc_partVertices, ///< into the frame; resets the lists
    qc_partBoxes,    ///< for the image only
    qc_partNodes,    ///< boxes of nodes; for the image: the cells they cover
    qc_partNodePairs,
    qc_partTrianglePairs,
    qc_partPairTests,
    qc_partOrder,
    qc_partWait,     ///< for the device; maps its results
    qc_partTimers,   ///< reads the times of the parts
    qc_partHandBack, ///< reads errors, returns to the calling thread
    qc_partRefine,   ///< on the calling thread: from the results to pairs of triangles
    qc_layersPartCount
} qcLayersPart;

/// A world coordinate x along axes[i] is (x - origin[i]) * unit in the frame.
typedef struct qcLayersFrame
{
    int axes[3];
    double origin[3], unit;
} qcLayersFrame;

/// Pointers stay valid until qcLayers_Run returns.
typedef struct qcLayersStep
{
    /// Elements of each input buffer. Where this exceeds the buffer's size, the buffer grows and loses its content.
    size_t capacity[qc_layersInputCount];
    const qcLayersUpload* uploads;
    size_t uploadCount;
    const qcLayersBody* bodies;
    uint32_t bodyCount;
    const qcLayersChunk* chunks; ///< those of `sources` last
    uint32_t chunkCount;
    const qcLayersSource* sources;
    uint32_t sourceCount;
    size_t floatCount;           ///< words written to qcLayersMemory::floats
    size_t vertexCount;          ///< vertices written to qcLayersMemory::vertices
    uint32_t triangleCount;      ///< of the step, bodies that do not take part included
    const uint32_t* activeNodes; ///< nodes of the step, changed ones first
    uint32_t changedNodes, activeCount;
    qcLayersFrame frame;
    float scale[3];                  ///< levels = coordinate * scale
    float slack[4];                  ///< levels by which boxes are enlarged; the fourth: along the diagonal
    uint32_t cellsLog2[3];           ///< columns, rows and slices of the image: 0..12 each, 0..24 in all
    float pointError, queryDistance; ///< in the frame
    bool testNeighbours;
    bool timed;
    double started; ///< `timed`: qcClock_Now at the hand-over
} qcLayersStep;

/// Memory of the next step that the caller writes, mapped where the device can.
typedef struct qcLayersMemory
{
    float* floats; ///< of chunks; as many as were requested
    /// By vertex: where this is not null, all vertices but those of rigid bodies are written here, in the frame, and
    /// have no chunks. It keeps its content while the capacity stays.
    qcPoint* vertices;
} qcLayersMemory;

#define QC_NO_ENTRY UINT32_MAX

/// A node in one cell's list.
typedef struct qcLayersEntry
{
    uint32_t node, next, cell, body; ///< `next`: index of the next entry in the list, or QC_NO_ENTRY
} qcLayersEntry;

/// The lists of the cells, and the boxes and vertices to refine them with, by node, cluster, vertex.
typedef struct qcLayersImage
{
    const qcLayersEntry* entries;
    uint32_t entryCount;
    const uint32_t (*nodeBoxes)[4];           ///< see qcLayers_PackBox
    const qcBox8 *clusterGroups, *nodeGroups; ///< boxes in levels: a cluster's triangles, a node's clusters
    const qcPoint* vertices;                  ///< in the frame
} qcLayersImage;

typedef struct qcLayersAnswer
{
    /// As qcRelatedPair_Make, lower word first: penetrating where the interiors surely intersect, otherwise disjoint,
    /// which stands for an unknown relation. Where the step before had many, the last ones are in order: most or all.
    /// Valid until the next step.
    const uint32_t (*pairs)[2];
    size_t pairCount;
    qcLayersImage image; ///< instead of pairs with `imageOnly`; valid until the next step
    uint64_t entries;
    uint64_t trianglePairs; ///< pairs with overlapping boxes, before the separating axes; 0 with `imageOnly`
    uint64_t skippedNodes;  ///< nodes outside their body's interest
    uint32_t reruns;
    uint64_t uploadedBytes, deviceBytes;
    uint32_t glCalls, waits; ///< of the step: calls of GL, and of those the ones that wait for the device
    /// By qcLayersPart, see qcGlTimers; null unless the step is timed. Valid until the next step.
    const double *threadMs, *deviceMs;
} qcLayersAnswer;

typedef struct qcLayers qcLayers;

/// With `imageOnly` the result is the image: links, pair masks and rules of bodies are not read.
/// qc_statusDevice on a device without compute shaders.
qcStatus qcLayers_Create(qcDevice* device, bool imageOnly, qcLayers** layers);
/// Whether the GL objects exist: false after the device was reopened, and for null.
bool qcLayers_IsAlive(const qcLayers* layers);
/// Whether the caller writes vertices in the frame: qcLayersMemory::vertices.
bool qcLayers_SharesVertices(const qcLayers* layers);
/// Null is allowed.
void qcLayers_Destroy(qcLayers* layers);

/// Begins a step, which qcLayers_Run ends: memory for its vertices. Waits for the device only where buffers grow.
qcStatus qcLayers_Open(qcLayers* layers, const qcLayersStep* step, qcLayersMemory* memory);
/// Submits the step that was opened, and waits for it. qc_statusDevice: the device's buffers can't hold the scene, or
/// the device fails.
qcStatus qcLayers_Run(qcLayers* layers, const qcLayersStep* step, qcLayersAnswer* answer);

/// Number of the cell at a column, row and slice.
static inline uint32_t qcLayers_CellAt(const uint32_t at[3], const uint32_t cellsLog2[3])
{
    return (at[2] << cellsLog2[1] | at[1]) << cellsLog2[0] | at[0];
}

/// Packs a box of levels: x, y, depth, (x + y) / 2. Levels are 1..qc_layersLevels, or 0 in an empty box.
static inline void qcLayers_PackBox(const uint32_t lower[4], const uint32_t upper[4], uint32_t box[4])
{
    box[0] = lower[0] | lower[1] << 16;
    box[1] = lower[2] | lower[3] << 16;
    box[2] = upper[0] | upper[1] << 16 | 0x80008000u;
    box[3] = upper[2] | upper[3] << 16 | 0x80008000u;
}

#endif
