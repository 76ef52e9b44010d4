// Bodies whose positions are on the device (qcScene_SetVertexBuffer) or kept as floats: they are read back, or become
// doubles, as far as a step needs them.
#ifndef QC_PIPELINE_VERTEX_BUFFERS_H
#define QC_PIPELINE_VERTEX_BUFFERS_H

#include "pipeline/island_routing.h"
#include "pipeline/step.h"
#include "quickcullide/buffers.h"
#include "scene/step_triangles.h"
#include "sweep/candidates.h"

/// Retained between steps.
typedef struct qcVertexBuffers
{
    qcArray items, scratch; ///< of qcSortItem: body of the step << 32 | vertex, of vertices to read
    qcArray vertices;       ///< uint32_t: those vertices, sorted by body
    qcArray parts;          ///< of qcSnapshotPart: those of a body
    qcArray positions;      ///< three floats for each
} qcVertexBuffers;

/// qcScene_SetVertexBuffer, for a deforming body.
qcStatus qcVertexBuffers_Set(qcBodies* bodies, uint32_t slot, qcDevice* device, const qcVertexBufferDef* def);
/// The body's positions are those of the CPU from now on.
void qcVertexBuffers_Leave(qcBody* body);
/// Before a body is removed.
void qcVertexBuffers_Release(qcBody* body);

/// Whether the step can do with the positions of candidates, where a device or BVHs find them.
bool qcVertexBuffers_SufficeFor(const qcStep* step);

/// Brings qcBody::world up to date; reads positions back if the CPU doesn't have them. `bytes` grows by those read.
qcStatus qcVertexBuffers_Complete(const qcBody* body, uint32_t slot, uint64_t* bytes);
/// Does so for all bodies of a scene.
qcStatus qcVertexBuffers_CompleteAll(const qcBodies* bodies, uint64_t* bytes);
/// Does so for the bodies of a step whose triangle pairs don't come from the device. Floats become no doubles where the
/// sweep of a body reads floats. `onDevice`: flags, by body of the step.
qcStatus qcVertexBuffers_CompleteOthers(const qcStep* step, const qcStepTriangles* triangles, const uint8_t* onDevice,
                                        uint64_t* bytes);
/// Brings qcBody::world up to date for bodies with pairs that neither a device nor BVHs find. `handledElsewhere`:
/// flags, by body of the step.
void qcVertexBuffers_LeaveFloats(const qcStepTriangles* triangles, const qcBodyPairs* pairs,
                                 const uint8_t* handledElsewhere);

/// After a step in which positions of candidates suffice: the next floats of bodies whose pairs a device or BVHs find
/// stay floats until a step needs doubles. `follows`: Verlet lists were in use, which need doubles.
qcStatus qcVertexBuffers_KeepFloats(const qcStep* step, const qcStepTriangles* triangles,
                                    const qcIslandRouting* routing, bool follows, qcBodies* bodies);

/// Brings qcBody::world up to date for triangles in candidate pairs whose positions the step reads from the device.
qcStatus qcVertexBuffers_Gather(const qcStep* step, const qcStepTriangles* triangles, const qcCandidates* candidates,
                                qcVertexBuffers* buffers, qcProfile* profile);
void qcVertexBuffers_Free(qcVertexBuffers* buffers);

#endif
