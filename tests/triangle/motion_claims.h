// What a certificate of motion claims, in exact arithmetic; shared by tests and fuzzers.
#ifndef QC_TESTS_TRIANGLE_MOTION_CLAIMS_H
#define QC_TESTS_TRIANGLE_MOTION_CLAIMS_H

#include "triangle/moving_pairs.h"

enum
{
    qc_times = 64
};

/// All corners of A are above all corners of B along the direction.
bool qcClaim_IsAbove(const double direction[3], const double corners[qc_cornerCount][3]);

/// True if the triangles have a common point that is not one of their common vertices or of their common edge. For
/// neighbours: see the_test_for_neighbours_is_that_of_the_oracle.
bool qcClaim_MeetElsewhere(const double corners[qc_cornerCount][3], int common);

/// At time k / 64, times 64: exact on the lattices of moving_pairs.h.
void qcClaim_GetPositions(const Pair* pair, int k, double corners[qc_cornerCount][3]);

#endif
