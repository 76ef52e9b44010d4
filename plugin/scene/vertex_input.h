// Positions as callers have them: single or double, at any stride. Checked first, read then: what is refused changes
// nothing, and nothing is kept in between.
#ifndef QC_SCENE_VERTEX_INPUT_H
#define QC_SCENE_VERTEX_INPUT_H

#include "quickcullide/scene.h"

typedef struct qcVertexInput
{
    const void* data;
    qcPositionType type;
    size_t stride; ///< bytes; 0: close together
    uint32_t count;
} qcVertexInput;

/// qc_statusBadInput, with a message that names the body's slot and the vertex, where they can't be read or one isn't
/// finite.
qcStatus qcVertexInput_Check(const qcVertexInput* positions, uint32_t slot);

/// Positions that were checked, three doubles each.
void qcVertexInput_Read(const qcVertexInput* positions, double* out);

#endif
