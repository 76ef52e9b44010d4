// The shortest difference of two triangles, in single precision, eight pairs side by side: the shortest between each
// two edges, and between each corner and the interior of the other face. (Ericson: Real-Time Collision Detection, 2005,
// 5.1.9.) The files of instruction sets include this one.
#ifndef QC_MANIFOLD_PAIR_DISTANCE_INL_H
#define QC_MANIFOLD_PAIR_DISTANCE_INL_H

#include "manifold/overlap_kernels.inl.h"

typedef float Floats __attribute__((vector_size(4 * qc_distanceLanes)));
typedef int32_t Ints __attribute__((vector_size(4 * qc_distanceLanes)));

/// Eight vectors, one a lane.
typedef struct Vectors8
{
    Floats x, y, z;
} Vectors8;

/// The shortest difference so far, of a point of triangle 0 and one of triangle 1.
typedef struct Shortest
{
    Vectors8 difference;
    Floats length2;
} Shortest;

/// A triangle of each pair.
typedef struct Triangles8
{
    Vectors8 corner[3], edge[3]; ///< edge e: from corner e to the next
    Floats edge2[3];             ///< squared lengths
    Vectors8 normal;             ///< of any length
    Floats normal2;
} Triangles8;

QC_INLINE Floats SelectFloats(Ints mask, Floats yes, Floats no)
{
    return (Floats)(((Ints)yes & mask) | ((Ints)no & ~mask));
}

QC_INLINE Floats ClampToUnit(Floats x)
{
    const Floats zero = {0}, one = zero + 1.0f;
    x = SelectFloats(x < one, x, one);
    return SelectFloats(x > zero, x, zero);
}

QC_INLINE Vectors8 Minus8(Vectors8 a, Vectors8 b)
{
    return (Vectors8){a.x - b.x, a.y - b.y, a.z - b.z};
}

QC_INLINE Vectors8 PlusScaled8(Vectors8 a, Vectors8 b, Floats s)
{
    return (Vectors8){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}

QC_INLINE Floats Dot8(Vectors8 a, Vectors8 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

QC_INLINE Vectors8 Cross8(Vectors8 a, Vectors8 b)
{
    return (Vectors8){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// NaN is never shorter.
QC_INLINE void KeepShorter(Shortest* best, Vectors8 difference, Ints allowed)
{
    Floats length2 = Dot8(difference, difference);
    Ints shorter = (length2 < best->length2) & allowed;
    best->difference.x = SelectFloats(shorter, difference.x, best->difference.x);
    best->difference.y = SelectFloats(shorter, difference.y, best->difference.y);
    best->difference.z = SelectFloats(shorter, difference.z, best->difference.z);
    best->length2 = SelectFloats(shorter, length2, best->length2);
}

QC_INLINE Vectors8 LoadVectors8(const float from[3][qc_distanceLanes])
{
    Vectors8 v;
    memcpy(&v.x, from[0], sizeof v.x);
    memcpy(&v.y, from[1], sizeof v.y);
    memcpy(&v.z, from[2], sizeof v.z);
    return v;
}

QC_INLINE Triangles8 LoadTriangles8(const float corner[3][3][qc_distanceLanes])
{
    Triangles8 t;
    for (int c = 0; c < 3; c++)
        t.corner[c] = LoadVectors8(corner[c]);
    for (int e = 0; e < 3; e++)
    {
        t.edge[e] = Minus8(t.corner[(e + 1) % 3], t.corner[e]);
        t.edge2[e] = Dot8(t.edge[e], t.edge[e]);
    }
    t.normal = Cross8(t.edge[2], t.edge[0]);
    t.normal2 = Dot8(t.normal, t.normal);
    return t;
}

QC_INLINE void TestEdges(Shortest* best, const Triangles8* a, int i, const Triangles8* b, int k)
{
    const Floats zero = {0}, minPositive = zero + 1e-30f;
    Vectors8 r = Minus8(a->corner[i], b->corner[k]);
    Floats d = Dot8(a->edge[i], b->edge[k]), c = Dot8(a->edge[i], r), f = Dot8(b->edge[k], r);
    Floats determinant = a->edge2[i] * b->edge2[k] - d * d;
    Floats s =
        ClampToUnit((d * f - c * b->edge2[k]) / SelectFloats(determinant > minPositive, determinant, minPositive));
    Floats t = ClampToUnit((d * s + f) / b->edge2[k]);
    s = ClampToUnit((d * t - c) / a->edge2[i]);
    KeepShorter(best, PlusScaled8(PlusScaled8(r, a->edge[i], s), b->edge[k], -t), zero == zero);
}

/// From a point to its foot on the face, if that is inside. `sign`: 1 for a point of triangle 0, -1 for one of 1.
QC_INLINE void TestFoot(Shortest* best, Vectors8 point, const Triangles8* face, float sign)
{
    const Floats zero = {0};
    Vectors8 p = Minus8(point, face->corner[0]), none = {zero, zero, zero};
    Ints inside = face->normal2 > 0.0f;
    for (int e = 0; e < 3; e++)
        inside &= Dot8(Cross8(face->edge[e], Minus8(point, face->corner[e])), face->normal) >= 0.0f;
    Floats height = Dot8(p, face->normal) / face->normal2;
    KeepShorter(best, PlusScaled8(none, face->normal, height * sign), inside);
}

static void FindDistances(const qcDistanceBatch* batch, float difference[3][qc_distanceLanes],
                          float length2[qc_distanceLanes])
{
    const Floats zero = {0};
    Triangles8 a = LoadTriangles8(batch->corner[0]), b = LoadTriangles8(batch->corner[1]);
    Shortest best = {{zero, zero, zero}, zero + INFINITY};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            TestEdges(&best, &a, i, &b, k);
    for (int c = 0; c < 3; c++)
    {
        TestFoot(&best, a.corner[c], &b, 1.0f);
        TestFoot(&best, b.corner[c], &a, -1.0f);
    }
    memcpy(difference[0], &best.difference.x, sizeof best.difference.x);
    memcpy(difference[1], &best.difference.y, sizeof best.difference.y);
    memcpy(difference[2], &best.difference.z, sizeof best.difference.z);
    memcpy(length2, &best.length2, sizeof best.length2);
}

#endif
