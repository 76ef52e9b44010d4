// Blocks of positions, for one size of words: included with WORD, an unsigned integer type, and NAME(function). The
// three axes of a block are computed together, so that the compiler vectorises the loops.

/// A small number for a small difference of either sign.
static inline WORD NAME(Zigzag)(WORD difference)
{
    return (WORD)(difference << 1 ^ -(difference >> (8 * sizeof(WORD) - 1)));
}

static inline WORD NAME(UndoZigzag)(WORD word)
{
    return (WORD)(word >> 1 ^ -(word & 1));
}

/// The width of the widest word of each axis.
static inline void NAME(FindWidths)(const WORD words[qc_blockWords], unsigned widths[3])
{
    // 12 lanes: whole vectors, and each lane belongs to one axis.
    WORD lanes[12] = {0};
    for (int i = 0; i < qc_blockWords; i += 12)
        for (int lane = 0; lane < 12; lane++)
            lanes[lane] |= words[i + lane];
    for (int axis = 0; axis < 3; axis++)
        widths[axis] = WidthOf((uint64_t)(lanes[axis] | lanes[axis + 3] | lanes[axis + 6] | lanes[axis + 9]));
}

/// 32 words of an axis, every third, of `width` bits. Up to qc_blockSlack bytes behind them are written.
static inline unsigned char* NAME(Pack)(const WORD* words, unsigned width, unsigned char* bytes)
{
    uint64_t bits = 0;
    unsigned filled = 0;
    unsigned char* at = bytes;
    for (int i = 0; i < qc_blockWords && width != 0; i += 3)
    {
        uint64_t word = words[i];
        bits |= word << filled;
        filled += width;
        if (filled >= 64)
        {
            memcpy(at, &bits, sizeof bits);
            at += sizeof bits;
            filled -= 64;
            bits = filled == 0 ? 0 : word >> (width - filled);
        }
    }
    memcpy(at, &bits, sizeof bits);
    return bytes + 4 * (size_t)width;
}

/// Writes a block of `count` vertices; `before` becomes the positions.
static unsigned char* NAME(EncodeBlock)(const unsigned char* positions, size_t stride, uint32_t count, const WORD* last,
                                        WORD* before, unsigned char* bytes)
{
    WORD words[qc_blockWords] = {0}, near[qc_blockWords] = {0}, far[qc_blockWords] = {0};
    for (uint32_t v = 0; v < count; v++)
        memcpy(words + 3 * v, positions + stride * v, 3 * sizeof *words);
    memcpy(near, last, 3 * count * sizeof *near);
    memcpy(far, before, 3 * count * sizeof *far);
    memcpy(before, words, 3 * count * sizeof *words);
    WORD still[qc_blockWords], continued[qc_blockWords];
    for (int i = 0; i < qc_blockWords; i++)
    {
        still[i] = NAME(Zigzag)((WORD)(words[i] - near[i]));
        continued[i] = NAME(Zigzag)((WORD)(words[i] - 2 * near[i] + far[i]));
    }
    unsigned stillWidths[3], continuedWidths[3];
    NAME(FindWidths)(still, stillWidths);
    NAME(FindWidths)(continued, continuedWidths);
    for (int axis = 0; axis < 3; axis++)
    {
        bool isContinued = continuedWidths[axis] < stillWidths[axis];
        unsigned width = isContinued ? continuedWidths[axis] : stillWidths[axis];
        *bytes++ = (unsigned char)(width | (isContinued ? qc_blockContinued : 0));
        bytes = NAME(Pack)((isContinued ? continued : still) + axis, width, bytes);
    }
    return bytes;
}

/// Reads a block; `before` becomes the positions. Null: the bytes are no such block.
static const unsigned char* NAME(DecodeBlock)(uint32_t count, const WORD* last, WORD* before,
                                              const unsigned char* bytes, const unsigned char* end)
{
    for (int axis = 0; axis < 3; axis++)
    {
        if (bytes == end)
            return NULL;
        unsigned width = *bytes & ~(unsigned)qc_blockContinued;
        bool isContinued = (*bytes++ & qc_blockContinued) != 0;
        if (width > 8 * sizeof(WORD) || (size_t)(end - bytes) < 4 * (size_t)width)
            return NULL;
        uint64_t words[qc_blockVertices];
        Unpack(bytes, width, words);
        bytes += 4 * (size_t)width;
        for (uint32_t v = 0; v < count; v++)
        {
            size_t i = 3 * (size_t)v + (size_t)axis;
            before[i] = (WORD)(NAME(UndoZigzag)((WORD)words[v]) + (isContinued ? 2 * last[i] - before[i] : last[i]));
        }
    }
    return bytes;
}
