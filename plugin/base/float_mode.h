// The floating-point environment that the proofs assume: round to nearest, subnormals kept, no traps. Public functions
// whose results depend on it set it and restore the caller's.
//
// x86-64: MXCSR alone, since nothing is computed in x87 registers. Other processors: <fenv.h>.
#ifndef QC_BASE_FLOAT_MODE_H
#define QC_BASE_FLOAT_MODE_H

#if defined(__x86_64__)

#include <stdbool.h>
#include <stdint.h>
#include <xmmintrin.h>

/// MXCSR of the caller.
typedef struct qcFloatMode
{
    uint32_t control;
} qcFloatMode;

/// The low six bits are exception flags, not modes.
static inline bool qcFloatMode_IsDefault(qcFloatMode mode)
{
    return (mode.control & ~0x3fu) == 0x1f80u;
}

/// Sets the default environment; returns the previous one. Put the computation into a function that is not inlined: the
/// compiler may move arithmetic across this call.
static inline qcFloatMode qcFloatMode_Begin(void)
{
    qcFloatMode mode = {_mm_getcsr()};
    // Writing takes some ten cycles more than reading, and is rarely needed.
    if (!qcFloatMode_IsDefault(mode))
        _mm_setcsr(0x1f80u);
    return mode;
}

/// Restores the environment.
static inline void qcFloatMode_End(qcFloatMode mode)
{
    if (!qcFloatMode_IsDefault(mode))
        _mm_setcsr(mode.control);
}

#else

#include <fenv.h>

typedef struct qcFloatMode
{
    fenv_t environment;
} qcFloatMode;

static inline qcFloatMode qcFloatMode_Begin(void)
{
    qcFloatMode mode;
    fegetenv(&mode.environment);
    fesetenv(FE_DFL_ENV);
    return mode;
}

static inline void qcFloatMode_End(qcFloatMode mode)
{
    fesetenv(&mode.environment);
}

#endif

#endif
