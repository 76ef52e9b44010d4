// Products of 64-bit integers, 128 bits wide, with the compiler's own type or, where it has none (32-bit processors),
// with two words. Both give the same integers.
#ifndef QC_TRIANGLE_WIDE_INTEGER_H
#define QC_TRIANGLE_WIDE_INTEGER_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __SIZEOF_INT128__

__extension__ typedef __int128 qcWide;
__extension__ typedef unsigned __int128 qcWideUnsigned;

/// The low word of a * b + c + d, which always fits into two.
static inline uint64_t qcWide_MultiplyAdd(uint64_t a, uint64_t b, uint64_t c, uint64_t d, uint64_t* high)
{
    qcWideUnsigned sum = (qcWideUnsigned)a * b + c + d;
    *high = (uint64_t)(sum >> 64);
    return (uint64_t)sum;
}

/// a * b - c * d; all below 2^63 in magnitude.
static inline qcWide qcWide_Minor(int64_t a, int64_t b, int64_t c, int64_t d)
{
    return (qcWide)a * b - (qcWide)c * d;
}

/// Sets |x|, low word first. True: x is negative.
static inline bool qcWide_Split(qcWide x, uint64_t magnitude[2])
{
    qcWideUnsigned y = x < 0 ? 0 - (qcWideUnsigned)x : (qcWideUnsigned)x;
    magnitude[0] = (uint64_t)y;
    magnitude[1] = (uint64_t)(y >> 64);
    return x < 0;
}

#else

/// Two's complement.
typedef struct qcWide
{
    uint64_t low, high;
} qcWide;

static inline uint64_t qcWide_MultiplyAdd(uint64_t a, uint64_t b, uint64_t c, uint64_t d, uint64_t* high)
{
    uint64_t a0 = (uint32_t)a, a1 = a >> 32, b0 = (uint32_t)b, b1 = b >> 32;
    uint64_t low = a0 * b0, middle = a1 * b0 + (low >> 32), cross = a0 * b1 + (uint32_t)middle;
    *high = a1 * b1 + (middle >> 32) + (cross >> 32);
    low = cross << 32 | (uint32_t)low;
    low += c;
    *high += low < c;
    low += d;
    *high += low < d;
    return low;
}

static inline qcWide qcWide_Minor(int64_t a, int64_t b, int64_t c, int64_t d)
{
    const int64_t factors[2][2] = {{a, b}, {c, d}};
    uint64_t low[2], high[2];
    for (int i = 0; i < 2; i++)
    {
        uint64_t x = (uint64_t)factors[i][0], y = (uint64_t)factors[i][1];
        low[i] = qcWide_MultiplyAdd(x, y, 0, 0, &high[i]);
        high[i] -= (factors[i][0] < 0 ? y : 0) + (factors[i][1] < 0 ? x : 0);
    }
    return (qcWide){low[0] - low[1], high[0] - high[1] - (uint64_t)(low[0] < low[1])};
}

static inline bool qcWide_Split(qcWide x, uint64_t magnitude[2])
{
    bool negative = x.high >> 63 != 0;
    magnitude[0] = negative ? 0 - x.low : x.low;
    magnitude[1] = negative ? 0 - x.high - (uint64_t)(x.low != 0) : x.high;
    return negative;
}

#endif

#endif
