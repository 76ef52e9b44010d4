// The bodies of a recording while it is read: what its operations refer to.
#ifndef QC_RECORDING_RECORDED_BODIES_H
#define QC_RECORDING_RECORDED_BODIES_H

#include "base/memory.h"
#include "quickcullide/recording.h"
#include "recording/position_coding.h"

typedef struct qcRecordedBody
{
    uint32_t generation; ///< odd while the body is there, as in a scene
    bool deforming;
    uint32_t vertexCount;
    qcPositionHistory positions; ///< of deforming bodies
} qcRecordedBody;

/// Indices that several bodies may have.
typedef struct qcIndexSet
{
    uint32_t* indices; ///< 3 * triangleCount
    uint32_t triangleCount;
    uint64_t vertexCount; ///< one more than the largest index
} qcIndexSet;

typedef struct qcRecordedBodies
{
    qcArray slots;       ///< of qcRecordedBody
    qcArray indexSets;   ///< of qcIndexSet
    uint32_t lowestFree; ///< all slots below are taken
} qcRecordedBodies;

/// The messages of all functions name the body.
qcStatus qcRecordedBodies_Add(qcRecordedBodies* bodies, uint32_t slot, bool deforming, uint32_t vertexCount);
qcStatus qcRecordedBodies_Find(const qcRecordedBodies* bodies, uint32_t slot, qcRecordedBody** body);
qcStatus qcRecordedBodies_Remove(qcRecordedBodies* bodies, uint32_t slot);
/// Copies indices as the next set.
qcStatus qcRecordedBodies_AddIndices(qcRecordedBodies* bodies, const uint32_t* indices, uint32_t triangleCount);
void qcRecordedBodies_Free(qcRecordedBodies* bodies);

#endif
