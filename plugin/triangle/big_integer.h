// Integers large enough for every polynomial in coordinates whose sign is computed.
#ifndef QC_TRIANGLE_BIG_INTEGER_H
#define QC_TRIANGLE_BIG_INTEGER_H

#include "triangle/wide_integer.h"

#include <stdbool.h>
#include <stdint.h>

enum
{
    qc_integerWords = 197
};

/// Sign and magnitude; words beyond `count` are not set.
typedef struct qcInteger
{
    bool negative;
    int count; ///< words in use; 0: the number is zero
    uint64_t word[qc_integerWords];
} qcInteger;

/// The largest e for which each of the values is an integer multiple of 2^e; any finite values.
int qcInteger_CommonExponent(const double* values, int count);
/// The values / 2^commonExponent if all are below 2^60 in magnitude, as most coordinates of one scene are; otherwise
/// false. Determinants of short integers take a few machine words.
bool qcInteger_AreShort(const double* values, int count, int commonExponent, int64_t* shorts);
/// x = value / 2^commonExponent.
void qcInteger_Set(qcInteger* x, double value, int commonExponent);
/// `sum` and `difference` may be a or b.
void qcInteger_Add(const qcInteger* a, const qcInteger* b, qcInteger* sum);
void qcInteger_Subtract(const qcInteger* a, const qcInteger* b, qcInteger* difference);
/// product = a * b
void qcInteger_MultiplyWide(int64_t a, qcWide b, qcInteger* product);
/// `product` is neither a nor b.
void qcInteger_Multiply(const qcInteger* a, const qcInteger* b, qcInteger* product);
int qcInteger_Sign(const qcInteger* x);

#endif
