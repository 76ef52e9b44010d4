// What is claimed of a pair of triangles, against rational arithmetic. A claim that fails ends the program, with the
// pair on standard error: tests and fuzzers share them.
#ifndef QC_TESTS_TRIANGLE_PAIR_CLAIMS_H
#define QC_TESTS_TRIANGLE_PAIR_CLAIMS_H

#include "support/oracle.h"
#include "support/pairs.h"

#include <math.h>
#include <stdbool.h>

/// The ends of the intersection segment are the farthest corners of the intersection. `exact`: of a penetrating pair.
void qcClaim_Segment(const qcTrianglePair* pair, const qcOracleAnswer* exact);

/// Closest points, their features, distance, depth and normal. The extent must not exceed a quarter of the largest
/// double.
void qcClaim_Proximity(const qcTrianglePair* pair);

/// The largest difference of coordinates to the first corner; infinite where that overflows.
double qcTrianglePair_GetExtent(const qcTrianglePair* pair);

/// Prints what failed, and ends the program.
void qcTrianglePair_Fail(const qcTrianglePair* pair, const char* what, double got, double expected);

#define QC_CLAIM(pair, condition, what, got, expected)                                                                 \
    do                                                                                                                 \
    {                                                                                                                  \
        if (!(condition))                                                                                              \
            qcTrianglePair_Fail(pair, what, got, expected);                                                            \
    } while (0)

static inline bool qcAreNear(const double p[3], const double q[3], double tolerance)
{
    for (int axis = 0; axis < 3; ++axis)
        if (!(fabs(p[axis] - q[axis]) <= tolerance))
            return false;
    return true;
}

#endif
