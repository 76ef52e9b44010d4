// The triangle test of all peers: in double, with a bound on its error, and the library's exact test where the bound
// does not decide. So every method must find the same pairs.
// Guigue, Devillers: Fast and robust triangle-triangle overlap test using orientation predicates, JGT 2003.
//
// The bound: coordinates are differences of doubles, at most e and f in size. Each is off by a rounding, each product
// and sum by another one, nine in a row at most; the determinant of rows e, e, f has six terms of at most e e f, so it
// is off by less than 6 * 9 * 2^-53 * e e f < 1e-14 * e e f. 1e-300 is far above what underflow takes away; after an
// overflow nothing is above the bound, and the exact test decides.
#ifndef QC_DEMOS_BENCH_PEERS_TRIANGLES_H
#define QC_DEMOS_BENCH_PEERS_TRIANGLES_H

#include "bench/peers/library.h"

#include <quickcullide/scene.h>

static inline void qcPeerTriangle_Get(const qcPeerBody* body, const qcPeerPose* pose, uint32_t triangle, double out[9])
{
    const uint32_t* t = body->indices + 3 * (size_t)triangle;
    for (int corner = 0; corner < 3; ++corner)
    {
        size_t first = 3 * (size_t)t[corner];
        for (size_t axis = 0; axis < 3; ++axis)
            out[3 * corner + (int)axis] =
                pose->floats != NULL ? (double)pose->floats[first + axis] : pose->doubles[first + axis];
    }
}

static inline bool qcPeerTriangle_AreNeighbours(const qcPeerBody* body, uint32_t a, uint32_t b)
{
    const uint32_t *s = body->indices + 3 * (size_t)a, *t = body->indices + 3 * (size_t)b;
    return s[0] == t[0] || s[0] == t[1] || s[0] == t[2] || s[1] == t[0] || s[1] == t[1] || s[1] == t[2] ||
           s[2] == t[0] || s[2] == t[1] || s[2] == t[2];
}

static inline double qcPeerTriangle_Larger(double a, double b)
{
    return a > b ? a : b;
}

static inline double qcPeerTriangle_Size(const double v[3])
{
    double x = v[0] < 0.0 ? -v[0] : v[0], y = v[1] < 0.0 ? -v[1] : v[1], z = v[2] < 0.0 ? -v[2] : v[2];
    return qcPeerTriangle_Larger(qcPeerTriangle_Larger(x, y), z);
}

static inline void qcPeerTriangle_Subtract(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; ++i)
        out[i] = a[i] - b[i];
}

/// The side of a triangle's plane on which each of `count` points lies: -1, 1, or 0: too near to decide.
static inline void qcPeerTriangle_Sides(const double* a, const double* b, const double* c, const double* const* points,
                                        int count, int* sides)
{
    double u[3], v[3], w[3], n[3];
    qcPeerTriangle_Subtract(b, a, u);
    qcPeerTriangle_Subtract(c, a, v);
    for (int i = 0; i < 3; ++i)
        n[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
    double e = qcPeerTriangle_Larger(qcPeerTriangle_Size(u), qcPeerTriangle_Size(v));
    for (int k = 0; k < count; ++k)
    {
        qcPeerTriangle_Subtract(points[k], a, w);
        double d = n[0] * w[0] + n[1] * w[1] + n[2] * w[2],
               bound = (1e-14 * e * e + 1e-300) * qcPeerTriangle_Size(w) + 1e-300;
        sides[k] = d > bound ? 1 : d < -bound ? -1 : 0;
    }
}

/// Rotates the corner that is alone on its side to the front, which keeps the orientation.
static inline void qcPeerTriangle_PutFirst(const double* p[3], int sides[3])
{
    int alone = sides[1] == sides[2] ? 0 : sides[0] == sides[2] ? 1 : 2;
    const double* old[3] = {p[0], p[1], p[2]};
    int oldSides[3] = {sides[0], sides[1], sides[2]};
    for (int i = 0; i < 3; ++i)
    {
        p[i] = old[(alone + i) % 3];
        sides[i] = oldSides[(alone + i) % 3];
    }
}

static inline void qcPeerTriangle_Flip(const double* p[3])
{
    const double* old = p[1];
    p[1] = p[2];
    p[2] = old;
}

/// 1: the triangles penetrate; 0: they don't; -1: rounding might change that.
static inline int qcPeerTriangle_Guess(const double* a, const double* b)
{
    const double *p[3] = {a, a + 3, a + 6}, *q[3] = {b, b + 3, b + 6};
    int ofP[3], ofQ[3], side[1];
    qcPeerTriangle_Sides(q[0], q[1], q[2], p, 3, ofP);
    if (ofP[0] == ofP[1] && ofP[1] == ofP[2] && ofP[0] != 0)
        return 0;
    qcPeerTriangle_Sides(p[0], p[1], p[2], q, 3, ofQ);
    if (ofQ[0] == ofQ[1] && ofQ[1] == ofQ[2] && ofQ[0] != 0)
        return 0;
    for (int i = 0; i < 3; ++i)
    {
        if (ofP[i] == 0 || ofQ[i] == 0)
            return -1;
    }
    // The first corner of each triangle is alone on its side, above the other's plane. Then the planes' common line
    // intersects the four edges from the first corners, and the two segments on it overlap if neither ends before the
    // other begins.
    qcPeerTriangle_PutFirst(p, ofP);
    qcPeerTriangle_PutFirst(q, ofQ);
    if (ofP[0] < 0)
        qcPeerTriangle_Flip(q);
    if (ofQ[0] < 0)
        qcPeerTriangle_Flip(p);
    qcPeerTriangle_Sides(p[0], p[1], q[0], &q[1], 1, side);
    if (side[0] > 0)
        return 0;
    int first = side[0];
    qcPeerTriangle_Sides(p[0], p[2], q[2], &q[0], 1, side);
    if (side[0] > 0)
        return 0;
    return first == 0 || side[0] == 0 ? -1 : 1;
}

/// Nine doubles each.
static inline bool qcPeerTriangle_Penetrate(const double* a, const double* b)
{
    int guess = qcPeerTriangle_Guess(a, b);
    return guess < 0 ? qcRelateTriangles(a, b) == qc_relationPenetrating : guess != 0;
}

#endif
