// Triangle against triangle, decided exactly for the given coordinates.
// Proofs: plugin/docs/proofs/intersection_test.md, distance_test.md, orientation_filter.md.
#ifndef QC_TRIANGLE_EXACT_H
#define QC_TRIANGLE_EXACT_H

#include "triangle/determinant.h"
#include "quickcullide/scene.h"

/// Like qcRelateTriangles. Adds to `*undecided` (may be null) the number of predicates that the floating-point filter
/// could not decide.
qcRelation qcExact_Relate(const double a[3][3], const double b[3][3], uint64_t* undecided);

/// Like qcExact_Relate, and qc_relationNear for disjoint triangles whose distance is at most `margin`, 0 or more. A
/// pair that the filter for distances could not decide adds one to `*undecided`.
qcRelation qcExact_Within(const double a[3][3], const double b[3][3], double margin, uint64_t* undecided);

/// The ends of the intersection of two penetrating triangles, rounded; see qcSegment.
void qcExact_Segment(const double a[3][3], const double b[3][3], qcSegment* segment);

//  ---- predicates, exact in sign; `undecided` as above ----------------------------------------------------

/// Sign of det(b - a, c - a, d - a): positive when d lies on the side to which (b - a) x (c - a) points.
int qcOrient3d(const double a[3], const double b[3], const double c[3], const double d[3], uint64_t* undecided);

/// qcOrient3d of a triangle's corners and each of three points, in less time.
void qcOrient3dSides(const double t[3][3], const double points[3][3], int side[3], uint64_t* undecided);

/// The determinant of qcOrient3d, right to at least 20 bits.
qcScaled qcOrient3dValue(const double a[3], const double b[3], const double c[3], const double d[3]);

/// Sign of det(b - a, c - a) in the coordinates (u, v).
int qcOrient2d(const double a[3], const double b[3], const double c[3], int u, int v, uint64_t* undecided);

//  ---- simplices --------------------------------------------------------------------------------------------

/// A triangle without its degeneracy: a point, a segment or a triangle. The corners are the caller's.
typedef struct qcSimplex
{
    int dimension;          ///< 0, 1 or 2
    const double* point[3]; ///< dimension + 1 corners, affinely independent
    /// Triangle: two coordinates in which it is not flat; `sign` is its orientation there.
    /// Segment: u is a coordinate in which its ends differ.
    int u, v, sign;
} qcSimplex;

qcSimplex qcSimplex_Of(const double triangle[3][3], uint64_t* undecided);

#endif
