// Determinants in integers of fixed size: all coordinates are scaled by one power of two until each is an
// integer, which loses nothing, and a determinant of integers is an integer.
//
// Why this can't overflow: a finite double is an integer multiple of 2^-1074 below 2^1024, so a scaled coordinate
// has at most 2098 bits, a difference 2099, a product of three 6297, and a sum of six such products 6300 bits:
// 99 words of 64. Nothing is rounded, so there is no underflow and no error bound. Usual coordinates (single
// precision, one scene) take one or two words; the cost grows with the square of the words in use.
#include "exact_integer.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum
{
    qc_maxWords = 99
};

__extension__ typedef unsigned __int128 Wide;

/// Sign and magnitude; words beyond `count` are not set.
typedef struct Integer
{
    bool negative;
    int count; ///< words in use; 0: the number is zero
    uint64_t word[qc_maxWords];
} Integer;

/// value = mantissa * 2^exponent, mantissa an integer.
static uint64_t Split(double value, int* exponent)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint64_t mantissa = bits & 0xfffffffffffffULL;
    int biased = (int)(bits >> 52 & 0x7ff);
    *exponent = biased == 0 ? -1074 : biased - 1075;
    return biased == 0 ? mantissa : mantissa | 1ULL << 52;
}

/// The largest e for which each of the values is an integer multiple of 2^e.
static int CommonExponent(const double* values, int count)
{
    int common = 2048;
    for (int i = 0; i < count; i++)
    {
        int exponent;
        uint64_t mantissa = Split(values[i], &exponent);
        if (mantissa == 0)
            continue;
        exponent += __builtin_ctzll(mantissa);
        if (exponent < common)
            common = exponent;
    }
    return common;
}

static void SetDouble(Integer* x, double value, int commonExponent)
{
    int exponent;
    uint64_t mantissa = Split(value, &exponent);
    x->negative = value < 0.0;
    x->count = 0;
    if (mantissa == 0)
        return;
    int zeros = __builtin_ctzll(mantissa);
    mantissa >>= zeros;
    int shift = exponent + zeros - commonExponent;
    assert(shift >= 0);
    int words = shift / 64, bits = shift % 64;
    memset(x->word, 0, (size_t)words * sizeof x->word[0]);
    x->word[words] = mantissa << bits;
    x->count = words + 1;
    uint64_t high = bits == 0 ? 0 : mantissa >> (64 - bits);
    if (high != 0)
        x->word[x->count++] = high;
}

static int CompareMagnitude(const Integer* a, const Integer* b)
{
    if (a->count != b->count)
        return a->count < b->count ? -1 : 1;
    for (int i = a->count - 1; i >= 0; i--)
        if (a->word[i] != b->word[i])
            return a->word[i] < b->word[i] ? -1 : 1;
    return 0;
}

static void AddMagnitude(const Integer* a, const Integer* b, Integer* sum)
{
    const Integer* large = a->count >= b->count ? a : b;
    const Integer* small = a->count >= b->count ? b : a;
    Wide carry = 0;
    int n = large->count;
    for (int i = 0; i < n; i++)
    {
        carry += large->word[i];
        if (i < small->count)
            carry += small->word[i];
        sum->word[i] = (uint64_t)carry;
        carry >>= 64;
    }
    if (carry != 0)
    {
        assert(n < qc_maxWords);
        sum->word[n++] = (uint64_t)carry;
    }
    sum->count = n;
}

/// |a| >= |b|
static void SubtractMagnitude(const Integer* a, const Integer* b, Integer* difference)
{
    uint64_t borrow = 0;
    int n = a->count;
    for (int i = 0; i < n; i++)
    {
        uint64_t take = i < b->count ? b->word[i] : 0;
        uint64_t low = a->word[i] - take;
        uint64_t next = (uint64_t)(a->word[i] < take) | (uint64_t)(low < borrow);
        difference->word[i] = low - borrow;
        borrow = next;
    }
    while (n > 0 && difference->word[n - 1] == 0)
        n--;
    difference->count = n;
}

/// sum = a + b, or a - b. `sum` may be a or b.
static void Add(const Integer* a, const Integer* b, bool subtract, Integer* sum)
{
    bool aNegative = a->negative, bNegative = b->negative != subtract;
    if (aNegative == bNegative)
    {
        AddMagnitude(a, b, sum);
        sum->negative = aNegative;
        return;
    }
    bool aLarger = CompareMagnitude(a, b) >= 0;
    if (aLarger)
        SubtractMagnitude(a, b, sum);
    else
        SubtractMagnitude(b, a, sum);
    sum->negative = aLarger ? aNegative : bNegative;
}

/// `product` is neither a nor b.
static void Multiply(const Integer* a, const Integer* b, Integer* product)
{
    product->negative = a->negative != b->negative;
    product->count = 0;
    if (a->count == 0 || b->count == 0)
        return;
    int n = a->count + b->count;
    assert(n <= qc_maxWords + 1);
    memset(product->word, 0, (size_t)(n < qc_maxWords ? n : qc_maxWords) * sizeof product->word[0]);
    for (int i = 0; i < a->count; i++)
    {
        Wide carry = 0;
        for (int j = 0; j < b->count; j++)
        {
            carry += (Wide)a->word[i] * b->word[j] + product->word[i + j];
            product->word[i + j] = (uint64_t)carry;
            carry >>= 64;
        }
        if (carry != 0)
            product->word[i + b->count] = (uint64_t)carry;
        else
            assert(i + b->count >= qc_maxWords || product->word[i + b->count] == 0);
    }
    if (n > qc_maxWords || product->word[n - 1] == 0)
        n--;
    product->count = n;
}

static int Sign(const Integer* x)
{
    return x->count == 0 ? 0 : x->negative ? -1 : 1;
}

/// x * 2^exponent, its highest 64 bits rounded to 53: the bits below change the rounding only.
static qcScaled ToScaled(const Integer* x, int exponent)
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
static void Minor(const Integer* a, const Integer* b, const Integer* c, const Integer* d, Integer* out)
{
    Integer other;
    Multiply(a, b, out);
    Multiply(c, d, &other);
    Add(out, &other, true, out);
}

qcScaled qcExactDeterminant3(const double a[3], const double b[3], const double c[3], const double d[3])
{
    double values[12];
    const double* points[4] = {a, b, c, d};
    for (int p = 0; p < 4; p++)
        memcpy(values + 3 * p, points[p], 3 * sizeof(double));
    int common = CommonExponent(values, 12);

    Integer row[3][3]; // the differences to a
    for (int axis = 0; axis < 3; axis++)
    {
        Integer origin;
        SetDouble(&origin, a[axis], common);
        for (int r = 0; r < 3; r++)
        {
            Integer end;
            SetDouble(&end, points[r + 1][axis], common);
            Add(&end, &origin, true, &row[r][axis]);
        }
    }
    Integer determinant = {.negative = false, .count = 0};
    for (int axis = 0; axis < 3; axis++)
    {
        int u = (axis + 1) % 3, v = (axis + 2) % 3;
        Integer minor, term;
        Minor(&row[1][u], &row[2][v], &row[1][v], &row[2][u], &minor);
        Multiply(&row[0][axis], &minor, &term);
        Add(&determinant, &term, false, &determinant);
    }
    return ToScaled(&determinant, 3 * common);
}

int qcExactSign2(double ax, double ay, double bx, double by, double cx, double cy)
{
    double values[6] = {ax, ay, bx, by, cx, cy};
    int common = CommonExponent(values, 6);
    Integer x[6];
    for (int i = 0; i < 6; i++)
        SetDouble(&x[i], values[i], common);
    for (int i = 2; i < 6; i++)
        Add(&x[i], &x[i % 2], true, &x[i]);
    Integer determinant;
    Minor(&x[2], &x[5], &x[3], &x[4], &determinant);
    return Sign(&determinant);
}
