// The relation of two triangles, by linear programming, and their distance, by quadratic programming, in rational
// arithmetic: what every test believes. Needs GMP. Any thread; nothing is kept between calls.
#ifndef QC_TESTS_SUPPORT_ORACLE_H
#define QC_TESTS_SUPPORT_ORACLE_H

#include "quickcullide/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

enum
{
    // Bases of a system in six unknowns: at most 6 over 3.
    qc_oracleMaxPoints = 20
};

typedef struct qcOracleAnswer
{
    qcRelation relation;
    /// Points that differ as doubles; 0 for a disjoint pair.
    int pointCount;
    /// Each coordinate is the exact one, cut off toward zero to a double. The corners of A ∩ B are all among them;
    /// degenerate triangles may add points between the corners.
    double points[qc_oracleMaxPoints][3];
} qcOracleAnswer;

/// The relation of two closed triangles, degenerate ones included, for any finite coordinates.
qcRelation qcOracle_Relate(const double a[3][3], const double b[3][3]);

/// The relation, and the points that span A ∩ B.
void qcOracle_Intersect(const double a[3][3], const double b[3][3], qcOracleAnswer* answer);

/// Sign of det(b - a, c - a, d - a).
int qcOracle_Orient3d(const double a[3], const double b[3], const double c[3], const double d[3]);

/// Sign of det(b - a, c - a) in the coordinates (u, v).
int qcOracle_Orient2d(const double a[3], const double b[3], const double c[3], int u, int v);

//  ---- distance ----------------------------------------------------------------------------------------

/// The exact distance of two closed triangles, degenerate ones included, for any finite coordinates.
typedef struct qcOracleDistance qcOracleDistance;

qcOracleDistance* qcOracleDistance_Create(const double a[3][3], const double b[3][3]);
void qcOracleDistance_Destroy(qcOracleDistance* distance);
/// The sign of the distance minus a margin of 0 or more.
int qcOracleDistance_Compare(const qcOracleDistance* distance, double margin);
/// To 2^-51 of itself; infinity beyond the largest double.
double qcOracleDistance_Get(const qcOracleDistance* distance);

/// How far A, which meets B, has to move along a normal of a face of either or across an edge of each until their
/// projections onto it overlap no more: the least over all these axes, both ways. To 2^-51 of itself.
double qcOracle_Depth(const double a[3][3], const double b[3][3]);

#ifdef __cplusplus
}
#endif

#endif
