// Encoding overwrites `before` block by block, after its last use, and then swaps it with `last`.
#include "recording/position_coding.h"

#include "base/memory.h"

#include <string.h>

enum
{
    qc_blockVertices = 32,
    qc_blockWords = 3 * qc_blockVertices,
    qc_blockContinued = 128,         ///< flag of a block's first byte
    qc_blockBytes = 1 + 4 * 64,      ///< of an axis: the byte, and 32 words of 64 bits
    qc_blockSlack = sizeof(uint64_t) ///< bytes written behind a block
};

static size_t WordSize(qcPositionType type)
{
    return type == qc_positionF64 ? sizeof(double) : sizeof(float);
}

//  ---- blocks ------------------------------------------------------------------------------------------------------

static unsigned WidthOf(uint64_t bits)
{
    return bits == 0 ? 0 : 64 - (unsigned)__builtin_clzll(bits);
}

static void Unpack(const unsigned char* bytes, unsigned width, uint64_t words[qc_blockVertices])
{
    unsigned char padded[(size_t)4 * 64 + 2 * sizeof(uint64_t)] = {0};
    memcpy(padded, bytes, 4 * (size_t)width);
    const uint64_t mask = width == 64 ? UINT64_MAX : ((uint64_t)1 << width) - 1;
    for (size_t i = 0, bit = 0; i < qc_blockVertices; i++, bit += width)
    {
        uint64_t low, high;
        memcpy(&low, padded + bit / 64 * 8, sizeof low);
        memcpy(&high, padded + bit / 64 * 8 + 8, sizeof high);
        size_t shift = bit % 64;
        words[i] = (low >> shift | (shift == 0 ? 0 : high << (64 - shift))) & mask;
    }
}

#define WORD uint32_t
#define NAME(function) function##32
#include "recording/position_blocks.inl.h"
#undef WORD
#undef NAME
#define WORD uint64_t
#define NAME(function) function##64
#include "recording/position_blocks.inl.h"

/// Vertices of the block that begins with vertex `first`.
static uint32_t CountFrom(const qcPositionHistory* history, size_t first)
{
    size_t left = history->vertexCount - first;
    return left < qc_blockVertices ? (uint32_t)left : qc_blockVertices;
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
    unsigned char* end = bytes;
    for (size_t first = 0; first < history->vertexCount; first += qc_blockVertices)
    {
        const unsigned char* from = (const unsigned char*)positions + step * first;
        uint32_t count = CountFrom(history, first);
        if (history->type == qc_positionF64)
            end = EncodeBlock64(from, step, count, (uint64_t*)history->last + 3 * first,
                                (uint64_t*)history->before + 3 * first, end);
        else
            end = EncodeBlock32(from, step, count, (uint32_t*)history->last + 3 * first,
                                (uint32_t*)history->before + 3 * first, end);
    }
    Swap(history);
    return (size_t)(end - bytes);
}

size_t qcPositions_Decode(qcPositionHistory* history, const unsigned char* bytes, size_t size)
{
    const unsigned char *at = bytes, *end = bytes + size;
    for (size_t first = 0; first < history->vertexCount && at != NULL; first += qc_blockVertices)
    {
        uint32_t count = CountFrom(history, first);
        if (history->type == qc_positionF64)
            at = DecodeBlock64(count, (uint64_t*)history->last + 3 * first, (uint64_t*)history->before + 3 * first, at,
                               end);
        else
            at = DecodeBlock32(count, (uint32_t*)history->last + 3 * first, (uint32_t*)history->before + 3 * first, at,
                               end);
    }
    Swap(history);
    return at != NULL ? (size_t)(at - bytes) : 0;
}
