// Seeded pairs of triangles, most of them on or next to the border between two relations. Built exactly from small
// integers and powers of two; disturbed pairs are off by a few ulps.
#ifndef QC_TESTS_SUPPORT_PAIRS_H
#define QC_TESTS_SUPPORT_PAIRS_H

#include "support/soups.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum qcPairKind
{
    qc_pairGeneral,        ///< uniform doubles
    qc_pairFloat,          ///< uniform floats
    qc_pairMixedExponents, ///< random exponent by coordinate, from denormals to the largest
    qc_pairCoarseGrid,     ///< coordinates 0, 1, 2: many coincidences
    qc_pairCoplanar,       ///< six corners on one lattice plane
    qc_pairVertexOnFace,
    qc_pairVertexOnEdge,
    qc_pairVertexOnVertex,
    qc_pairEdgeThroughFace,
    qc_pairEdgeThroughEdge,
    qc_pairCollinearEdges, ///< disjoint, touching, overlapping or contained
    qc_pairSharedEdge,
    qc_pairEdgeInFace,
    qc_pairContained, ///< one in the other, the border included
    qc_pairIdentical,
    qc_pairSmallOnLarge, ///< corners at 2^-10 .. 2^-40 around a point of the other
    qc_pairSliver,       ///< one is 2^-10 .. 2^-40 wide
    qc_pairDegenerate,   ///< another kind, where one or both are segments or points
    qc_pairKindCount
} qcPairKind;

typedef struct qcTrianglePair
{
    double a[3][3], b[3][3];
    qcPairKind kind;
} qcTrianglePair;

/// A pair exactly of the kind, its corners and the two triangles in any order.
void qcTrianglePair_Make(qcRandom* random, qcPairKind kind, qcTrianglePair* pair);

/// Scales by 1e-6 .. 1e6 or, rarely, up to the largest double or down to the denormals; translates by up to 1e7; moves
/// up to three coordinates by up to three ulps. Each step is applied with some probability. Results are finite.
void qcTrianglePair_Disturb(qcRandom* random, qcTrianglePair* pair);

/// A disjoint pair at an exactly known distance: the hull of `cornersA` (1..3) corners of A and that of `cornersB`
/// corners of B have closest points on the two planes of an empty slab of this width. The pair is then translated by up
/// to 1e7 and scaled by a power of two, an extreme one for a tenth of all pairs, without rounding.
void qcTrianglePair_MakeApart(qcRandom* random, int cornersA, int cornersB, qcTrianglePair* pair, double* distance);

/// Moves up to three coordinates by up to three ulps, of their own or of the largest coordinate.
void qcTrianglePair_MoveByUlps(qcRandom* random, qcTrianglePair* pair);

/// A pair of any kind, disturbed.
void qcTrianglePair_MakeAny(qcRandom* random, qcTrianglePair* pair);

/// The largest coordinate in magnitude.
double qcTrianglePair_GetLargest(const qcTrianglePair* pair);

/// The kind and the coordinates in C's hexadecimal notation. Returns `text`.
char* qcTrianglePair_Print(const qcTrianglePair* pair, char text[1024]);

/// The number of pairs to try: the environment variable QC_TEST_PAIRS, at least `minCount`.
int qcGetTestPairCount(int minCount);

#ifdef __cplusplus
}
#endif

#endif
