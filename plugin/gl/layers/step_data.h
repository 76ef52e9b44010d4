// The data of a step of `layers` as the kernels read it: parameters, bodies, active nodes, chunks and floats, one
// behind the other in the stream.
#ifndef QC_GL_LAYERS_STEP_DATA_H
#define QC_GL_LAYERS_STEP_DATA_H

#include "gl/layers/layers_lists.h"
#include "gl/layers/layers_stream.h"

/// Words from the start of a step's data.
typedef struct qcStepPlaces
{
    size_t nodes, chunks, floats, end; ///< parameters are the first, then bodies
} qcStepPlaces;

qcStepPlaces qcStepData_FindPlaces(const qcLayersStep* step);
/// Bytes that the processor writes for a step, beside its uploads and parameters.
size_t qcStepData_ByteCount(const qcLayersStep* step);

/// Chunks whose floats lie in the stream.
uint32_t qcStepData_OwnChunkCount(const qcLayersStep* step);
/// Workgroups of qc_kernelNodePairs.
uint64_t qcStepData_ComparingGroupCount(const qcLayersStep* step);
/// Words of qc_workLists between the counters and the buckets.
uint32_t qcStepData_ListWords(const qcLayersStep* step, bool imageOnly);
/// The word of qc_workLists where the buckets begin.
uint32_t qcStepData_BucketsAt(const qcLayersStep* step, bool imageOnly);

/// Writes bodies, active nodes and chunks.
void qcStepData_Write(const qcLayersStep* step, const qcLayersStream* stream);
/// Writes the parameters of a run: they depend on the room that the lists have.
void qcStepData_WriteParameters(const qcLayersStep* step, const qcLayersLists* lists, const qcLayersBuffers* buffers,
                                uint32_t runNumber, const qcLayersStream* stream);

#endif
