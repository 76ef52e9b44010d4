// A deforming body's positions on the device: a copy, made there, of those in a buffer of the host's. Since it is a
// copy, the host may write its buffer as soon as the copy is made, and a step may be repeated.
#ifndef QC_GL_BUFFERS_VERTEX_SNAPSHOT_H
#define QC_GL_BUFFERS_VERTEX_SNAPSHOT_H

#include "base/memory.h"
#include "gl/buffers/device_buffer.h"

typedef struct qcVertexSnapshot
{
    qcDevice* device;
    uint32_t generation; ///< of the device, when the positions were copied
    uint32_t vertexCount;
    bool active;       ///< the body's positions are these
    bool complete;     ///< all of them have been read back into qcBody::world, too
    bool lost;         ///< the context that held them is gone
    GLuint buffers[2]; ///< three floats a vertex; the second is the next copy's
    GLuint bounds, used;
    bool allocated; ///< all of them, in the context of the generation
    qcArray marks;  ///< uint32_t, by vertex: the number of the last list with it
    uint32_t listNumber;
    uint32_t runNumber; ///< of the last copy
} qcVertexSnapshot;

typedef struct qcSnapshotSource
{
    qcBufferRange range; ///< from the first position to the end of the last
    uint32_t stride;     ///< bytes
    void* fence;
    /// By vertex: 1 if a triangle has it, else 0. Null: all have one. Vertices without a triangle have no part in the
    /// bounds.
    const uint8_t* used;
    uint32_t slot; ///< of the body, for messages
} qcSnapshotSource;

/// Vertices to read back: a part of one list.
typedef struct qcSnapshotPart
{
    const qcVertexSnapshot* snapshot;
    size_t first, count; ///< of the list
} qcSnapshotPart;

/// Without positions yet.
qcStatus qcVertexSnapshot_Create(qcDevice* device, uint32_t vertexCount, qcVertexSnapshot** snapshot);
/// Null is allowed.
void qcVertexSnapshot_Destroy(qcVertexSnapshot* snapshot);

/// Copies positions and finds their bounds; lower > upper if there are none. Waits for the device. On failure the
/// previous positions stay.
qcStatus qcVertexSnapshot_Copy(qcVertexSnapshot* snapshot, const qcSnapshotSource* source, float lower[3],
                               float upper[3]);

/// Whether the body's positions are on the device and nowhere else.
static inline bool qcVertexSnapshot_IsOnlyCopy(const qcVertexSnapshot* snapshot)
{
    return snapshot != NULL && snapshot->active && !snapshot->complete;
}

/// Whether the body's positions are on the device.
bool qcVertexSnapshot_IsOnDevice(const qcVertexSnapshot* snapshot);

/// qc_statusDeviceLost: the positions were lost with the context that held them.
qcStatus qcVertexSnapshot_CheckAlive(const qcVertexSnapshot* snapshot, uint32_t slot);

/// Reads all positions back, three floats a vertex.
qcStatus qcVertexSnapshot_Read(const qcVertexSnapshot* snapshot, float* positions);

/// Reads back the positions of listed vertices, three floats each, with one wait for all parts.
qcStatus qcVertexSnapshots_Gather(qcDevice* device, const qcSnapshotPart* parts, size_t partCount,
                                  const uint32_t* vertices, size_t vertexCount, float* positions);

#endif
