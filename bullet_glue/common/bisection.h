// Search for the end of a range over which something holds.
#ifndef QC_GLUE_COMMON_BISECTION_H
#define QC_GLUE_COMMON_BISECTION_H

#include <LinearMath/btScalar.h>

/// The value up to which `holds` is true, below the last bisection's width: it is true at `low`, and not at `high`.
template <class Holds> btScalar qcBisect(btScalar low, btScalar high, int bisections, const Holds& holds)
{
    for (int i = 0; i < bisections; i++)
    {
        const btScalar middle = (low + high) / 2;
        (holds(middle) ? low : high) = middle;
    }
    return low;
}

#endif
