// Vectors by hand: of twelve numbers in a row, which are three vectors of floats, compilers find some of the minima and
// maxima side by side, and the others one by one (gcc 12: three times as long).
#include "base/aabb.h"

#include "base/four_floats.h"
#include "base/two_doubles.h"

#include <float.h>

enum
{
    qc_boundsRun = 12 ///< numbers: four vertices
};

/// Defines a function over positions of one type.
#define QC_DEFINE_INCLUDE(Name, Number, Vector, Load, Min, Max, limit)                                                 \
    void Name(const Number* positions, size_t vertexCount, double lower[3], double upper[3])                           \
    {                                                                                                                  \
        enum                                                                                                           \
        {                                                                                                              \
            width = sizeof(Vector) / sizeof(Number),                                                                   \
            vectors = qc_boundsRun / width                                                                             \
        };                                                                                                             \
        Vector low[vectors], high[vectors];                                                                            \
        size_t count = 3 * vertexCount, i = 0;                                                                         \
        for (int v = 0; v < vectors; v++)                                                                              \
        {                                                                                                              \
            low[v] = (limit) - (Vector){0};                                                                            \
            high[v] = -(limit) - (Vector){0};                                                                          \
        }                                                                                                              \
        for (; i + qc_boundsRun <= count; i += qc_boundsRun)                                                           \
            for (size_t v = 0; v < vectors; v++)                                                                       \
            {                                                                                                          \
                Vector x = Load(positions + i + width * v);                                                            \
                low[v] = Min(low[v], x);                                                                               \
                high[v] = Max(high[v], x);                                                                             \
            }                                                                                                          \
        for (int k = 0; k < qc_boundsRun && vertexCount != 0; k++)                                                     \
        {                                                                                                              \
            double min = (double)low[k / width][k % width], max = (double)high[k / width][k % width];                  \
            lower[k % 3] = min < lower[k % 3] ? min : lower[k % 3];                                                    \
            upper[k % 3] = max > upper[k % 3] ? max : upper[k % 3];                                                    \
        }                                                                                                              \
        for (int axis = 0; i < count; i++, axis = (axis + 1) % 3)                                                      \
        {                                                                                                              \
            lower[axis] = (double)positions[i] < lower[axis] ? (double)positions[i] : lower[axis];                     \
            upper[axis] = (double)positions[i] > upper[axis] ? (double)positions[i] : upper[axis];                     \
        }                                                                                                              \
    }

QC_DEFINE_INCLUDE(qcBounds_Include, double, qcTwoDoubles, qcTwoDoubles_Load, qcTwoDoubles_Min, qcTwoDoubles_Max,
                  DBL_MAX)
QC_DEFINE_INCLUDE(qcBounds_IncludeFloats, float, qcFourFloats, qcFourFloats_Load, qcFourFloats_Min, qcFourFloats_Max,
                  FLT_MAX)
