// Seeded triangle soups for all tests: a seed gives the same bits on every machine.
// Random numbers: Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014 (splitmix64).
#ifndef QC_TESTS_SUPPORT_SOUPS_H
#define QC_TESTS_SUPPORT_SOUPS_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

//  ---- random numbers ------------------------------------------------------------------------------

/// The state is the seed; any value will do.
typedef struct qcRandom
{
    uint64_t state;
} qcRandom;

uint64_t qcRandom_Next(qcRandom* random);
/// 0 .. bound - 1, bound > 0.
uint32_t qcRandom_Below(qcRandom* random, uint32_t bound);
/// An integer in lower .. upper, as a double.
double qcRandom_Integer(qcRandom* random, int lower, int upper);
/// lower <= result < upper.
double qcRandom_Uniform(qcRandom* random, double lower, double upper);

//  ---- soups ---------------------------------------------------------------------------------------

/// An indexed triangle soup; positions are three doubles a vertex. Without memory for it the program ends.
typedef struct qcSoup
{
    double* positions;
    uint32_t vertexCount;
    uint32_t* indices;
    uint32_t triangleCount;
} qcSoup;

void qcSoup_Free(qcSoup* soup);

/// The corners of a triangle.
void qcSoup_GetTriangle(const qcSoup* soup, uint32_t triangle, double corners[3][3]);

/// True if two triangles have a vertex index in common.
bool qcSoup_AreNeighbours(const qcSoup* soup, uint32_t triangleA, uint32_t triangleB);

/// Rounds each position to the nearest float.
void qcSoup_RoundToFloat(qcSoup* soup);

/// Translates every vertex.
void qcSoup_Translate(qcSoup* soup, double x, double y, double z);

/// Moves the first triangles behind the others.
void qcSoup_RotateTriangles(qcSoup* soup, uint32_t count);

/// Triangles in general position, corners at most `size` (per axis) from a centre in the unit box; no shared
/// vertices.
qcSoup qcSoup_MakeRandom(uint64_t seed, uint32_t triangleCount, double size);

/// Like qcSoup_MakeRandom; about `share` (0..1) of the triangles are segments, points, or have a vertex twice.
qcSoup qcSoup_MakeDegenerate(uint64_t seed, uint32_t triangleCount, double size, double share);

/// side * side squares of two triangles each, exactly in the plane z = 0, over [0, 1] x [0, 1].
qcSoup qcSoup_MakeGrid(uint32_t side);

/// A sheet of side * side squares, folded twice onto itself in three layers `gap` apart, each vertex moved by up to
/// `noise` in z: triangles of different layers penetrate where the noise is larger than about gap / 2.
qcSoup qcSoup_MakeFoldedCloth(uint64_t seed, uint32_t side, double gap, double noise);

/// A closed mesh of 20 * 4^level triangles around the origin.
qcSoup qcSoup_MakeSphere(uint32_t level, double radius);

/// `layerCount` flat grids, `gap` apart in z: boxes overlap little, and triangles of different layers are disjoint.
qcSoup qcSoup_MakeSheets(uint32_t layerCount, uint32_t side, double gap);

#ifdef __cplusplus
}
#endif

#endif
