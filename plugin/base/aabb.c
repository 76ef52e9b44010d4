// Compiled for finite numbers without signed zeros (plugin/CMakeLists.txt): minimum and maximum are then one
// instruction each, for several numbers at once.
#include "base/aabb.h"

#include <float.h>

enum
{
    qc_boundsRun = 12 ///< numbers: four vertices
};

/// Defines a function over positions of one type.
#define QC_DEFINE_INCLUDE(Name, Number, limit)                                                                         \
    void Name(const Number* positions, size_t vertexCount, double lower[3], double upper[3])                           \
    {                                                                                                                  \
        Number low[qc_boundsRun], high[qc_boundsRun];                                                                  \
        size_t count = 3 * vertexCount, i = 0;                                                                         \
        for (size_t k = 0; k < qc_boundsRun; k++)                                                                      \
        {                                                                                                              \
            low[k] = limit;                                                                                            \
            high[k] = -limit;                                                                                          \
        }                                                                                                              \
        for (; i + qc_boundsRun <= count; i += qc_boundsRun)                                                           \
            for (size_t k = 0; k < qc_boundsRun; k++)                                                                  \
            {                                                                                                          \
                low[k] = positions[i + k] < low[k] ? positions[i + k] : low[k];                                        \
                high[k] = positions[i + k] > high[k] ? positions[i + k] : high[k];                                     \
            }                                                                                                          \
        for (int k = 0; i < count; i++, k++)                                                                           \
        {                                                                                                              \
            low[k] = positions[i] < low[k] ? positions[i] : low[k];                                                    \
            high[k] = positions[i] > high[k] ? positions[i] : high[k];                                                 \
        }                                                                                                              \
        for (int k = 0; k < qc_boundsRun && vertexCount != 0; k++)                                                     \
        {                                                                                                              \
            lower[k % 3] = (double)low[k] < lower[k % 3] ? (double)low[k] : lower[k % 3];                              \
            upper[k % 3] = (double)high[k] > upper[k % 3] ? (double)high[k] : upper[k % 3];                            \
        }                                                                                                              \
    }

QC_DEFINE_INCLUDE(qcBounds_Include, double, DBL_MAX)
QC_DEFINE_INCLUDE(qcBounds_IncludeFloats, float, FLT_MAX)
