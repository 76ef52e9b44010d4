// A caller's vertex positions: single or double, at any stride. They are checked before they are read.
#ifndef QC_SCENE_VERTEX_INPUT_H
#define QC_SCENE_VERTEX_INPUT_H

#include "quickcullide/scene.h"

typedef struct qcVertexInput
{
    const void* data;
    qcPositionType type;
    size_t stride; ///< bytes; 0: tightly packed
    uint32_t count;
} qcVertexInput;

/// qc_statusBadInput, with the body's slot and the vertex in the message: type, pointer or stride are invalid, or a
/// position isn't finite.
qcStatus qcVertexInput_Check(const qcVertexInput* positions, uint32_t slot);

/// Copies checked positions, three doubles each.
void qcVertexInput_Read(const qcVertexInput* positions, double* out);

#endif
