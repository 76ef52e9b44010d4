// Seeded pairs of triangles, most of them on or next to the border between two relations.
// Exact for small integers and powers of two; what is disturbed afterwards is off by a rounding or two.
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
    qc_pairMixedExponents, ///< each coordinate of a magnitude of its own, denormals to the largest
    qc_pairCoarseGrid,     ///< coordinates 0, 1, 2: every coincidence often
    qc_pairCoplanar,       ///< six corners of one lattice plane
    qc_pairVertexOnFace,
    qc_pairVertexOnEdge,
    qc_pairVertexOnVertex,
    qc_pairEdgeThroughFace,
    qc_pairEdgeThroughEdge,
    qc_pairCollinearEdges, ///< apart, touching, overlapping or one in the other
    qc_pairSharedEdge,
    qc_pairEdgeInFace,
    qc_pairContained, ///< one in the other, up to the same border
    qc_pairIdentical,
    qc_pairSmallOnLarge, ///< corners at 2^-10 .. 2^-40 around a point of the other
    qc_pairSliver,       ///< one of 2^-10 .. 2^-40 in width
    qc_pairDegenerate,   ///< one of the above; one or both are segments or points
    qc_pairKindCount
} qcPairKind;

typedef struct qcTrianglePair
{
    double a[3][3], b[3][3];
    qcPairKind kind;
} qcTrianglePair;

/// A pair exactly as the kind says, its corners and the two triangles in any order.
void qcTrianglePair_Make(qcRandom* random, qcPairKind kind, qcTrianglePair* pair);

/// Scales by 1e-6 .. 1e6 or, rarely, up to the largest double or down to the denormals, moves by up to 1e7, then
/// moves up to three coordinates by up to three ulps; each with a chance to be left out. All stay finite.
void qcTrianglePair_Disturb(qcRandom* random, qcTrianglePair* pair);

/// A pair exactly `distance` apart: a point of A's hull of `cornersA` (1..3) corners and one of B's of `cornersB` lie
/// this far from each other, on the two planes of an empty slab. Then scaled by a power of two, for a tenth of all
/// pairs an extreme one, and moved by up to 1e7 times that, without rounding.
void qcTrianglePair_MakeApart(qcRandom* random, int cornersA, int cornersB, qcTrianglePair* pair, double* distance);

/// Moves up to three coordinates by up to three ulps, their own or those of the largest.
void qcTrianglePair_MoveByUlps(qcRandom* random, qcTrianglePair* pair);

/// A pair of any kind, disturbed.
void qcTrianglePair_MakeAny(qcRandom* random, qcTrianglePair* pair);

/// The largest coordinate in magnitude.
double qcTrianglePair_GetLargest(const qcTrianglePair* pair);

/// The kind and the coordinates in C's hexadecimal notation. Returns `text`.
char* qcTrianglePair_Print(const qcTrianglePair* pair, char text[1024]);

/// How many pairs to try: what QC_TEST_PAIRS in the environment says, but at least `least`.
int qcGetTestPairCount(int least);

#ifdef __cplusplus
}
#endif

#endif
