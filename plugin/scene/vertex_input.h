// A caller's vertex positions: single or double, at any stride. They are checked before they are read.
#ifndef QC_SCENE_VERTEX_INPUT_H
#define QC_SCENE_VERTEX_INPUT_H

#include "quickcullide/scene.h"

enum
{
    // Vertices that are checked or copied at a time, in about a microsecond; a multiple of eight, so that no two blocks
    // share a cache line of doubles. Fewer than so many blocks take less time than waking a thread.
    qc_inputBlock = 1024,
    qc_minInputBlocks = 16
};

typedef struct qcVertexInput
{
    const void* data;
    qcPositionType type;
    size_t stride; ///< bytes; 0: tightly packed
    uint32_t count;
} qcVertexInput;

/// qc_statusBadInput, with the body's slot in the message: type, pointer or stride are invalid.
qcStatus qcVertexInput_CheckLayout(const qcVertexInput* positions, uint32_t slot);
/// qc_statusBadInput, with the body's slot and the vertex in the message: the layout is invalid, or a position isn't
/// finite.
qcStatus qcVertexInput_Check(const qcVertexInput* positions, uint32_t slot, uint32_t threads);
/// The failure of positions of which one isn't finite.
qcStatus qcVertexInput_FailNotFinite(const qcVertexInput* positions, uint32_t slot);

static inline size_t qcVertexInput_BlockCount(const qcVertexInput* positions)
{
    return ((size_t)positions->count + qc_inputBlock - 1) / qc_inputBlock;
}

/// A block of checked positions. It begins at vertex `block` * qc_inputBlock.
qcVertexInput qcVertexInput_Block(const qcVertexInput* positions, size_t block);

/// Copies checked positions, three doubles each.
void qcVertexInput_Read(const qcVertexInput* positions, double* out);
/// Copies positions of qc_positionF32, three floats each, and extends a box by them. False: one isn't finite; the box
/// is then meaningless.
bool qcVertexInput_ReadFloats(const qcVertexInput* positions, float* out, double lower[3], double upper[3]);

#endif
