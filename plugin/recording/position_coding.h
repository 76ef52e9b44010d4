// Positions of a deforming body, predicted from its last two: lossless, and short where the motion is smooth. In words:
// the bits of a coordinate as an unsigned integer. Neighbouring floats are neighbouring integers.
//
// 32 vertices make a block, each axis on its own: a byte (the width of the words in bits, plus 128 if the motion is
// continued: the prediction is last + (last - before), not last), then 32 differences from the prediction, zigzag, that
// wide. A block that ends early is filled with zeros. Lemire, Boytsov: Decoding billions of integers per second through
// vectorization, 2015 (blocks of one width).
#ifndef QC_RECORDING_POSITION_CODING_H
#define QC_RECORDING_POSITION_CODING_H

#include "quickcullide/scene.h"

/// The last two positions of a body, tightly packed. All zeros: there are none.
typedef struct qcPositionHistory
{
    void *last, *before;
    qcPositionType type;
    uint32_t vertexCount;
} qcPositionHistory;

/// Positions without a predecessor. False: out of memory, and there is no history any more.
bool qcPositionHistory_Start(qcPositionHistory* history, const void* positions, qcPositionType type, size_t stride,
                             uint32_t vertexCount);
void qcPositionHistory_Free(qcPositionHistory* history);
/// Bytes that qcPositions_Encode writes at most.
size_t qcPositions_MaxSize(const qcPositionHistory* history);
/// Encodes positions of the history's type and number, and adds them to it. Returns the number of bytes.
size_t qcPositions_Encode(qcPositionHistory* history, const void* positions, size_t stride, unsigned char* bytes);
/// Adds encoded positions to the history, as `last`. Returns the number of bytes that were read; 0: `size` bytes are no
/// such positions, and the history is spoiled.
size_t qcPositions_Decode(qcPositionHistory* history, const unsigned char* bytes, size_t size);

#endif
