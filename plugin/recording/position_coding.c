// Encoding overwrites `before` block by block, after its last use, and then swaps it with `last`.
#include "recording/position_coding.h"

#include "base/memory.h"

#include <string.h>

enum
{
    qc_blockVertices = 32,
    qc_blockContinued = 128,         ///< flag of a block's first byte
    qc_blockBytes = 1 + 4 * 64,      ///< of an axis: the byte, and 32 words of 64 bits
    qc_blockSlack = sizeof(uint64_t) ///< bytes written behind a block
};

static size_t WordSize(qcPositionType type)
{
    return type == qc_positionF64 ? sizeof(double) : sizeof(float);
}

//  ---- words -------------------------------------------------------------------------------------------------------

// Inlined where the size is a constant: a loop for each.
static inline uint64_t Load(const void* words, size_t index, size_t wordSize)
{
    uint32_t narrow;
    uint64_t wide;
    if (wordSize == sizeof wide)
        memcpy(&wide, (const char*)words + sizeof wide * index, sizeof wide);
    else
    {
        memcpy(&narrow, (const char*)words + sizeof narrow * index, sizeof narrow);
        wide = narrow;
    }
    return wide;
}

static inline void Store(void* words, size_t index, size_t wordSize, uint64_t word)
{
    uint32_t narrow = (uint32_t)word;
    if (wordSize == sizeof word)
        memcpy((char*)words + sizeof word * index, &word, sizeof word);
    else
        memcpy((char*)words + sizeof narrow * index, &narrow, sizeof narrow);
}

/// A small number for a small difference of either sign.
static inline uint64_t Zigzag(uint64_t difference, size_t wordSize)
{
    uint32_t narrow = (uint32_t)difference;
    return wordSize == sizeof difference ? difference << 1 ^ -(difference >> 63)
                                         : (uint32_t)(narrow << 1 ^ -(narrow >> 31));
}

static inline uint64_t UndoZigzag(uint64_t word)
{
    return word >> 1 ^ -(word & 1);
}

/// 32 words of `width` bits. Returns the end of the bytes; up to qc_blockSlack more are written.
static unsigned char* PackBits(const uint64_t words[qc_blockVertices], unsigned width, unsigned char* bytes)
{
    uint64_t bits = 0;
    unsigned filled = 0;
    unsigned char* at = bytes;
    for (int i = 0; i < qc_blockVertices && width != 0; i++)
    {
        bits |= words[i] << filled;
        if (filled + width < 64)
            filled += width;
        else
        {
            memcpy(at, &bits, sizeof bits);
            at += sizeof bits;
            bits = filled == 0 ? 0 : words[i] >> (64 - filled);
            filled = filled + width - 64;
        }
    }
    memcpy(at, &bits, sizeof bits);
    return bytes + 4 * (size_t)width;
}

static void UnpackBits(const unsigned char* bytes, unsigned width, uint64_t words[qc_blockVertices])
{
    unsigned char padded[4 * 64 + 2 * sizeof(uint64_t)] = {0};
    memcpy(padded, bytes, 4 * (size_t)width);
    const uint64_t mask = width == 64 ? UINT64_MAX : ((uint64_t)1 << width) - 1;
    for (unsigned i = 0, bit = 0; i < qc_blockVertices; i++, bit += width)
    {
        uint64_t low, high;
        memcpy(&low, padded + bit / 64 * 8, sizeof low);
        memcpy(&high, padded + bit / 64 * 8 + 8, sizeof high);
        unsigned shift = bit % 64;
        words[i] = (low >> shift | (shift == 0 ? 0 : high << (64 - shift))) & mask;
    }
}

static unsigned WidthOf(uint64_t bits)
{
    return bits == 0 ? 0 : 64 - (unsigned)__builtin_clzll(bits);
}

//  ---- blocks ------------------------------------------------------------------------------------------------------

/// A block's vertices along one axis: indices first, first + 3, ... of the history.
static inline unsigned char* EncodeAxis(qcPositionHistory* history, const char* positions, size_t stride, size_t first,
                                        uint32_t count, size_t wordSize, unsigned char* bytes)
{
    uint64_t still[qc_blockVertices] = {0}, continued[qc_blockVertices] = {0}, stillBits = 0, continuedBits = 0;
    for (uint32_t i = 0; i < count; i++)
    {
        size_t index = first + 3 * (size_t)i;
        uint64_t word = Load(positions + stride * i, 0, wordSize), last = Load(history->last, index, wordSize);
        still[i] = Zigzag(word - last, wordSize);
        continued[i] = Zigzag(word - 2 * last + Load(history->before, index, wordSize), wordSize);
        stillBits |= still[i];
        continuedBits |= continued[i];
        Store(history->before, index, wordSize, word);
    }
    unsigned stillWidth = WidthOf(stillBits), continuedWidth = WidthOf(continuedBits);
    bool isContinued = continuedWidth < stillWidth;
    unsigned width = isContinued ? continuedWidth : stillWidth;
    *bytes++ = (unsigned char)(width | (isContinued ? qc_blockContinued : 0));
    return PackBits(isContinued ? continued : still, width, bytes);
}

/// Null: the bytes are no such block.
static inline const unsigned char* DecodeAxis(qcPositionHistory* history, size_t first, uint32_t count, size_t wordSize,
                                              const unsigned char* bytes, const unsigned char* end)
{
    if (bytes == end)
        return NULL;
    unsigned width = *bytes & ~(unsigned)qc_blockContinued;
    bool isContinued = (*bytes++ & qc_blockContinued) != 0;
    if (width > 8 * wordSize || (size_t)(end - bytes) < 4 * (size_t)width)
        return NULL;
    uint64_t words[qc_blockVertices];
    UnpackBits(bytes, width, words);
    for (uint32_t i = 0; i < count; i++)
    {
        size_t index = first + 3 * (size_t)i;
        uint64_t last = Load(history->last, index, wordSize), before = Load(history->before, index, wordSize);
        Store(history->before, index, wordSize, UndoZigzag(words[i]) + (isContinued ? 2 * last - before : last));
    }
    return bytes + 4 * (size_t)width;
}

/// Vertices of the block that begins with vertex `first`.
static uint32_t CountFrom(const qcPositionHistory* history, size_t first)
{
    size_t left = history->vertexCount - first;
    return left < qc_blockVertices ? (uint32_t)left : qc_blockVertices;
}

static inline unsigned char* Encode(qcPositionHistory* history, const char* positions, size_t stride, size_t wordSize,
                                    unsigned char* bytes)
{
    for (size_t first = 0; first < history->vertexCount; first += qc_blockVertices)
        for (size_t axis = 0; axis < 3; axis++)
            bytes = EncodeAxis(history, positions + stride * first + wordSize * axis, stride, 3 * first + axis,
                               CountFrom(history, first), wordSize, bytes);
    return bytes;
}

/// Null: the bytes are no such positions.
static inline const unsigned char* Decode(qcPositionHistory* history, size_t wordSize, const unsigned char* bytes,
                                          const unsigned char* end)
{
    for (size_t first = 0; first < history->vertexCount; first += qc_blockVertices)
        for (size_t axis = 0; axis < 3 && bytes != NULL; axis++)
            bytes = DecodeAxis(history, 3 * first + axis, CountFrom(history, first), wordSize, bytes, end);
    return bytes;
}

//  ---- histories ---------------------------------------------------------------------------------------------------

static size_t SizeOf(const qcPositionHistory* history)
{
    return 3 * WordSize(history->type) * history->vertexCount;
}

static void Swap(qcPositionHistory* history)
{
    void* last = history->last;
    history->last = history->before;
    history->before = last;
}

void qcPositionHistory_Free(qcPositionHistory* history)
{
    qcFree(history->last, SizeOf(history));
    qcFree(history->before, SizeOf(history));
    *history = (qcPositionHistory){0};
}

bool qcPositionHistory_Start(qcPositionHistory* history, const void* positions, qcPositionType type, size_t stride,
                             uint32_t vertexCount)
{
    if (history->last == NULL || history->type != type || history->vertexCount != vertexCount)
    {
        qcPositionHistory_Free(history);
        *history = (qcPositionHistory){NULL, NULL, type, vertexCount};
        history->last = qcAllocate(SizeOf(history));
        history->before = qcAllocate(SizeOf(history));
    }
    if (vertexCount == 0)
        return true;
    if (history->last == NULL || history->before == NULL)
    {
        qcPositionHistory_Free(history);
        return false;
    }
    size_t size = 3 * WordSize(type), step = stride != 0 ? stride : size;
    for (uint32_t v = 0; v < vertexCount; v++)
        memcpy((char*)history->last + size * v, (const char*)positions + step * v, size);
    memcpy(history->before, history->last, SizeOf(history));
    return true;
}

size_t qcPositions_MaxSize(const qcPositionHistory* history)
{
    size_t blocks = ((size_t)history->vertexCount + qc_blockVertices - 1) / qc_blockVertices;
    return 3 * blocks * qc_blockBytes + qc_blockSlack;
}

size_t qcPositions_Encode(qcPositionHistory* history, const void* positions, size_t stride, unsigned char* bytes)
{
    size_t step = stride != 0 ? stride : 3 * WordSize(history->type);
    unsigned char* end = history->type == qc_positionF64 ? Encode(history, positions, step, sizeof(double), bytes)
                                                         : Encode(history, positions, step, sizeof(float), bytes);
    Swap(history);
    return (size_t)(end - bytes);
}

size_t qcPositions_Decode(qcPositionHistory* history, const unsigned char* bytes, size_t size)
{
    const unsigned char* end = history->type == qc_positionF64 ? Decode(history, sizeof(double), bytes, bytes + size)
                                                               : Decode(history, sizeof(float), bytes, bytes + size);
    Swap(history);
    return end != NULL ? (size_t)(end - bytes) : 0;
}
