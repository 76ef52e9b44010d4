// Integers of a fixed number of words, large enough for every polynomial whose sign is computed. Coordinates are scaled
// by one power of two until each is an integer: nothing is rounded and nothing overflows.
// Proof: plugin/docs/proofs/big_integer.md. The cost grows with the square of the words in use; usual coordinates
// (single precision, one scene) take one or two.
#include "triangle/big_integer.h"

#include <assert.h>
#include <math.h>
#include <string.h>

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

int qcInteger_CommonExponent(const double* values, int count)
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

bool qcInteger_AreShort(const double* values, int count, int commonExponent, int64_t* shorts)
{
    double limit = ldexp(1.0, commonExponent + 60);
    for (int i = 0; i < count; i++)
    {
        if (!(fabs(values[i]) < limit))
            return false;
        int exponent;
        uint64_t mantissa = Split(values[i], &exponent);
        int shift = mantissa != 0 ? exponent - commonExponent : 0;
        int64_t magnitude = (int64_t)(shift < 0 ? mantissa >> -shift : mantissa << shift);
        shorts[i] = values[i] < 0.0 ? -magnitude : magnitude;
    }
    return true;
}

void qcInteger_Set(qcInteger* x, double value, int commonExponent)
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

static int CompareMagnitude(const qcInteger* a, const qcInteger* b)
{
    if (a->count != b->count)
        return a->count < b->count ? -1 : 1;
    for (int i = a->count - 1; i >= 0; i--)
        if (a->word[i] != b->word[i])
            return a->word[i] < b->word[i] ? -1 : 1;
    return 0;
}

static void AddMagnitude(const qcInteger* a, const qcInteger* b, qcInteger* sum)
{
    const qcInteger* large = a->count >= b->count ? a : b;
    const qcInteger* small = a->count >= b->count ? b : a;
    uint64_t carry = 0;
    int n = large->count;
    for (int i = 0; i < n; i++)
        sum->word[i] = qcWide_MultiplyAdd(1, large->word[i], i < small->count ? small->word[i] : 0, carry, &carry);
    if (carry != 0)
    {
        assert(n < qc_integerWords);
        sum->word[n++] = carry;
    }
    sum->count = n;
}

/// |a| >= |b|
static void SubtractMagnitude(const qcInteger* a, const qcInteger* b, qcInteger* difference)
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

static void AddSigned(const qcInteger* a, const qcInteger* b, bool bNegative, qcInteger* sum)
{
    bool aNegative = a->negative;
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

void qcInteger_Add(const qcInteger* a, const qcInteger* b, qcInteger* sum)
{
    AddSigned(a, b, b->negative, sum);
}

void qcInteger_Subtract(const qcInteger* a, const qcInteger* b, qcInteger* difference)
{
    AddSigned(a, b, !b->negative, difference);
}

void qcInteger_MultiplyWide(int64_t a, qcWide b, qcInteger* product)
{
    uint64_t x = a < 0 ? 0 - (uint64_t)a : (uint64_t)a;
    uint64_t y[2];
    bool bNegative = qcWide_Split(b, y);
    product->negative = (a < 0) != bNegative;
    product->word[0] = qcWide_MultiplyAdd(x, y[0], 0, 0, &product->word[1]);
    product->word[1] = qcWide_MultiplyAdd(x, y[1], product->word[1], 0, &product->word[2]);
    product->count = 3;
    while (product->count > 0 && product->word[product->count - 1] == 0)
        product->count--;
}

void qcInteger_Multiply(const qcInteger* a, const qcInteger* b, qcInteger* product)
{
    product->negative = a->negative != b->negative;
    product->count = 0;
    if (a->count == 0 || b->count == 0)
        return;
    int n = a->count + b->count;
    assert(n <= qc_integerWords + 1);
    memset(product->word, 0, (size_t)(n < qc_integerWords ? n : qc_integerWords) * sizeof product->word[0]);
    for (int i = 0; i < a->count; i++)
    {
        uint64_t carry = 0;
        for (int j = 0; j < b->count; j++)
        {
            uint64_t* word = &product->word[i + j];
            *word = qcWide_MultiplyAdd(a->word[i], b->word[j], *word, carry, &carry);
        }
        if (carry != 0)
            product->word[i + b->count] = carry;
        else
            assert(i + b->count >= qc_integerWords || product->word[i + b->count] == 0);
    }
    if (n > qc_integerWords || product->word[n - 1] == 0)
        n--;
    product->count = n;
}

int qcInteger_Sign(const qcInteger* x)
{
    return x->count == 0 ? 0 : x->negative ? -1 : 1;
}
