// The oracle of all tests: the relation of two triangles by linear programming, and their distance by quadratic
// programming, in rational arithmetic (GMP). Proofs: plugin/docs/proofs/oracle.md. Thread-safe; without state.
#ifndef QC_TESTS_SUPPORT_ORACLE_H
#define QC_TESTS_SUPPORT_ORACLE_H

#include "quickcullide/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

enum
{
    // Bases of a system in six unknowns: at most 6 choose 3.
    qc_oracleMaxPoints = 20
};

typedef struct qcOracleAnswer
{
    qcRelation relation;
    /// Number of different points; 0 for a disjoint pair.
    int pointCount;
    /// Each coordinate is the exact one, rounded toward zero. The corners of A ∩ B are all among them;
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
/// The distance with a relative error of 2^-51; infinity on overflow.
double qcOracleDistance_Get(const qcOracleDistance* distance);

/// The penetration depth of two intersecting triangles: the minimum, over face normals and cross products of edges in
/// both directions, of the distance that A moves until the projections onto this axis no longer overlap. With a
/// relative error of 2^-51.
double qcOracle_Depth(const double a[3][3], const double b[3][3]);

#ifdef __cplusplus
}
#endif

#endif
