// Functions of one or two numbers, inline where the C library's are calls.
#ifndef QC_BASE_SCALAR_H
#define QC_BASE_SCALAR_H

#include <stdint.h>
#include <string.h>

/// Like fmin, but without its handling of NaN: y if one is NaN.
static inline double qcMin(double x, double y)
{
    return x < y ? x : y;
}

/// Like fmax, but without its handling of NaN: y if one is NaN.
static inline double qcMax(double x, double y)
{
    return x > y ? x : y;
}

/// floor, which SSE2 lacks. Never -0.
static inline double qcFloor(double x)
{
    // Larger doubles are integers. NaN is returned unchanged.
    if (!(x > -0x1p52 && x < 0x1p52))
        return x;
    double whole = (double)(int64_t)x;
    return whole > x ? whole - 1.0 : whole;
}

/// 2^exponent for -1022 .. 1023.
static inline double qcPowerOfTwo(int exponent)
{
    uint64_t bits = (uint64_t)(1023 + exponent) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

#endif
