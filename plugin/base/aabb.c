// Compiled for numbers that are finite, whose zeros have no sign: then least and greatest are one instruction each, and
// several lie side by side (CMakeLists.txt).
#include "base/aabb.h"

#include <float.h>

enum
{
    qc_boundsRun = 12 ///< numbers: four vertices
};

void qcBounds_Include(const double* positions, size_t vertexCount, double lower[3], double upper[3])
{
    double least[qc_boundsRun], most[qc_boundsRun];
    size_t count = 3 * vertexCount, i = 0;
    for (int k = 0; k < qc_boundsRun; k++)
    {
        least[k] = DBL_MAX;
        most[k] = -DBL_MAX;
    }
    for (; i + qc_boundsRun <= count; i += qc_boundsRun)
        for (int k = 0; k < qc_boundsRun; k++)
        {
            least[k] = positions[i + k] < least[k] ? positions[i + k] : least[k];
            most[k] = positions[i + k] > most[k] ? positions[i + k] : most[k];
        }
    for (int k = 0; i < count; i++, k++)
    {
        least[k] = positions[i] < least[k] ? positions[i] : least[k];
        most[k] = positions[i] > most[k] ? positions[i] : most[k];
    }
    for (int k = 0; k < qc_boundsRun; k++)
    {
        lower[k % 3] = least[k] < lower[k % 3] ? least[k] : lower[k % 3];
        upper[k % 3] = most[k] > upper[k % 3] ? most[k] : upper[k % 3];
    }
}
