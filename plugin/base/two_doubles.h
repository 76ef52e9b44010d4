// Two doubles side by side, on any CPU.
#ifndef QC_BASE_TWO_DOUBLES_H
#define QC_BASE_TWO_DOUBLES_H

#include <string.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

typedef double qcTwoDoubles __attribute__((vector_size(16)));

static inline qcTwoDoubles qcTwoDoubles_Both(double x)
{
    return (qcTwoDoubles){x, x};
}

/// No alignment is needed.
static inline qcTwoDoubles qcTwoDoubles_Load(const double* from)
{
    qcTwoDoubles doubles;
    memcpy(&doubles, from, sizeof doubles);
    return doubles;
}

/// The second where one is no number.
static inline qcTwoDoubles qcTwoDoubles_Min(qcTwoDoubles a, qcTwoDoubles b)
{
#ifdef __SSE2__
    return (qcTwoDoubles)_mm_min_pd((__m128d)a, (__m128d)b);
#else
    return (qcTwoDoubles){a[0] < b[0] ? a[0] : b[0], a[1] < b[1] ? a[1] : b[1]};
#endif
}

static inline qcTwoDoubles qcTwoDoubles_Max(qcTwoDoubles a, qcTwoDoubles b)
{
#ifdef __SSE2__
    return (qcTwoDoubles)_mm_max_pd((__m128d)a, (__m128d)b);
#else
    return (qcTwoDoubles){a[0] > b[0] ? a[0] : b[0], a[1] > b[1] ? a[1] : b[1]};
#endif
}

#endif
