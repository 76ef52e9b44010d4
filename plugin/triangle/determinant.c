// Determinants in integers.
#include "triangle/determinant.h"

#include "triangle/big_integer.h"

#include <math.h>
#include <string.h>

/// x * 2^exponent. The highest 64 bits are rounded to 53; lower ones would affect the rounding only.
static qcScaled ToScaled(const qcInteger* x, int exponent)
{
    qcScaled scaled = {0.0, 0};
    if (x->count == 0)
        return scaled;
    uint64_t top = x->word[x->count - 1];
    int zeros = __builtin_clzll(top);
    top <<= zeros;
    if (zeros > 0 && x->count > 1)
        top |= x->word[x->count - 2] >> (64 - zeros);
    int binary;
    scaled.mantissa = frexp((double)top, &binary);
    if (x->negative)
        scaled.mantissa = -scaled.mantissa;
    scaled.exponent = binary + exponent + (x->count - 1) * 64 - zeros;
    return scaled;
}

/// out = a * b - c * d
static void Minor(const qcInteger* a, const qcInteger* b, const qcInteger* c, const qcInteger* d, qcInteger* out)
{
    qcInteger other;
    qcInteger_Multiply(a, b, out);
    qcInteger_Multiply(c, d, &other);
    qcInteger_Subtract(out, &other, out);
}

/// qcExactDeterminant3 of coordinates below 2^60: differences are below 2^61, minors below 2^123, products below 2^184.
static void ShortDeterminant3(const int64_t x[12], qcInteger* determinant)
{
    int64_t row[3][3];
    for (int i = 0; i < 9; i++)
        row[i / 3][i % 3] = x[3 + i] - x[i % 3];
    determinant->count = 0;
    determinant->negative = false;
    for (int axis = 0; axis < 3; axis++)
    {
        int u = (axis + 1) % 3, v = (axis + 2) % 3;
        qcInteger term;
        qcInteger_MultiplyWide(row[0][axis], qcWide_Minor(row[1][u], row[2][v], row[1][v], row[2][u]), &term);
        qcInteger_Add(determinant, &term, determinant);
    }
}

qcScaled qcExactDeterminant3(const double a[3], const double b[3], const double c[3], const double d[3])
{
    double values[12];
    const double* points[4] = {a, b, c, d};
    for (size_t p = 0; p < 4; p++)
        memcpy(values + 3 * p, points[p], 3 * sizeof(double));
    int common = qcInteger_CommonExponent(values, 12);
    int64_t shorts[12];
    qcInteger determinant;
    if (qcInteger_AreShort(values, 12, common, shorts))
    {
        ShortDeterminant3(shorts, &determinant);
        return ToScaled(&determinant, 3 * common);
    }

    qcInteger row[3][3]; // the differences to a
    for (int axis = 0; axis < 3; axis++)
    {
        qcInteger origin;
        qcInteger_Set(&origin, a[axis], common);
        for (int r = 0; r < 3; r++)
        {
            qcInteger end;
            qcInteger_Set(&end, points[r + 1][axis], common);
            qcInteger_Subtract(&end, &origin, &row[r][axis]);
        }
    }
    qcInteger_Set(&determinant, 0.0, common);
    for (int axis = 0; axis < 3; axis++)
    {
        int u = (axis + 1) % 3, v = (axis + 2) % 3;
        qcInteger minor, term;
        Minor(&row[1][u], &row[2][v], &row[1][v], &row[2][u], &minor);
        qcInteger_Multiply(&row[0][axis], &minor, &term);
        qcInteger_Add(&determinant, &term, &determinant);
    }
    return ToScaled(&determinant, 3 * common);
}

int qcExactSign2(double ax, double ay, double bx, double by, double cx, double cy)
{
    double values[6] = {ax, ay, bx, by, cx, cy};
    int common = qcInteger_CommonExponent(values, 6);
    int64_t s[6];
    if (qcInteger_AreShort(values, 6, common, s))
    {
        uint64_t word[2];
        bool negative = qcWide_Split(qcWide_Minor(s[2] - s[0], s[5] - s[1], s[3] - s[1], s[4] - s[0]), word);
        return (word[0] | word[1]) == 0 ? 0 : negative ? -1 : 1;
    }
    qcInteger x[6];
    for (int i = 0; i < 6; i++)
        qcInteger_Set(&x[i], values[i], common);
    for (int i = 2; i < 6; i++)
        qcInteger_Subtract(&x[i], &x[i % 2], &x[i]);
    qcInteger determinant;
    Minor(&x[2], &x[5], &x[3], &x[4], &determinant);
    return qcInteger_Sign(&determinant);
}
