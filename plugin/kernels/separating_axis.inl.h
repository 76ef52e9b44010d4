// The kernels that compare triangles, in single precision: what is surely apart, and what surely penetrates.
//
// Filter. For any vector w, if the projections on w of all points of A and all points of B are further apart than
// r |w|, so are the triangles. Coordinates are wrong by at most e (pointError). They are taken relative to one vertex
// and scaled by a power of two s, exactly, so that the largest is in [1, 2): each is then wrong by 2 e s + 2^-22. An
// operation is taken to be right to one unit in the last place, fused or not. A product of three terms with w is wrong
// by at most |w|_1 (2 e s + 2^-22 + 4 * 2 * 2^-23), the difference of two such by twice that and its own rounding
// |w|_1 2^-21: together |w|_1 (4 e s + 2.9e-6). A gap of |w|_1 ((4 e + r) s 1.0001 + 4e-6) is asked for, and |w|_1 >=
// |w|. Axes shorter than 1e-20, where products could vanish, don't count. A triangle has its size from its corners: if
// all are one point, the scale is the greatest power of two, nothing is apart, and the pair stays.
//
// Sure hits. An edge whose ends are on different sides of a triangle's plane, and whose line passes all three edges on
// the same side, goes through the inside of the triangle: the two penetrate. Each sign is that of a determinant of
// differences u, v, w of corners, below 4 in each coordinate, wrong by h = 4 e s + 3 * 2^-22. To first order that
// changes the determinant by h (|v x w|_1 + |w x u|_1 + |u x v|_1), and by 72 h^2 + 6 h^3 at most besides; crosses are
// computed to 2^-18, which 100 h^2 and the constant cover (from h = 2 on that is more than any determinant); rounding
// adds at most 1792 * 2^-24.
#ifndef QC_KERNELS_SEPARATING_AXIS_INL_H
#define QC_KERNELS_SEPARATING_AXIS_INL_H

#include "kernels/triangle_kernels.h"

typedef float Floats __attribute__((vector_size(4 * QC_LANES)));
typedef int32_t Ints __attribute__((vector_size(4 * QC_LANES)));

typedef struct Vectors
{
    Floats x, y, z;
} Vectors;

/// QC_LANES pairs: corners seen from the first of A, the size of coordinates in [1, 2).
typedef struct Lanes
{
    Vectors b, c, d, e, f;
    Floats up;    ///< what they were scaled by
    Floats error; ///< of a coordinate, before they were taken relative to another
    Floats gap;   ///< least distance of projections on an axis, by the sum of its sizes
} Lanes;

QC_INLINE Vectors LoadPoints(const qcPoint* points, const uint32_t vertex[QC_LANES]);
QC_INLINE uint32_t SignBits(Ints lanes);

QC_INLINE Floats Absolute(Floats a)
{
    return (Floats)((Ints)a & 0x7fffffff);
}

QC_INLINE Vectors Subtract(Vectors a, Vectors b)
{
    return (Vectors){a.x - b.x, a.y - b.y, a.z - b.z};
}

QC_INLINE Vectors Times(Vectors a, Floats s)
{
    return (Vectors){a.x * s, a.y * s, a.z * s};
}

QC_INLINE Vectors Cross(Vectors a, Vectors b)
{
    return (Vectors){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

QC_INLINE Floats Dot(Vectors a, Vectors b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

QC_INLINE Floats MaxAbsolute(Vectors a)
{
    return MaxFloats(MaxFloats(Absolute(a.x), Absolute(a.y)), Absolute(a.z));
}

/// Where the axis separates: all bits.
QC_INLINE Ints Separates(const Lanes* l, Vectors axis)
{
    const Floats zero = {0};
    Floats u = Dot(axis, l->b), v = Dot(axis, l->c), p = Dot(axis, l->d), q = Dot(axis, l->e), r = Dot(axis, l->f);
    Floats least = (Absolute(axis.x) + Absolute(axis.y) + Absolute(axis.z)) * l->gap;
    Floats above = MinFloats(p, MinFloats(q, r)) - MaxFloats(zero, MaxFloats(u, v));
    Floats below = MinFloats(zero, MinFloats(u, v)) - MaxFloats(p, MaxFloats(q, r));
    return (MaxFloats(above, below) > least) & (MaxFloats(above, below) > 1e-20f);
}

QC_INLINE Vectors TransformPoints(const qcDistanceThresholds* bound, Vectors p)
{
    if (!bound->isTransformed)
        return p;
    Floats x[3];
    for (int i = 0; i < 3; i++)
    {
        const float* row = bound->linear[i];
        x[i] = p.x * row[0] + p.y * row[1] + p.z * row[2] + bound->shift[i];
    }
    return (Vectors){x[0], x[1], x[2]};
}

/// Pairs at .. at + QC_LANES; past the end the last one stands again.
QC_INLINE Lanes LoadLanes(const qcIndexedTriangles* a, const qcIndexedTriangles* b, const qcDistanceThresholds* bound,
                          const qcSlotPair* pairs, size_t count)
{
    uint32_t id[6][QC_LANES];
    for (size_t lane = 0; lane < QC_LANES; lane++)
    {
        qcSlotPair pair = pairs[lane < count ? lane : count - 1];
        const uint32_t *p = a->corners[pair.a].vertex, *q = b->corners[pair.b].vertex;
        for (int c = 0; c < 3; c++)
        {
            id[c][lane] = p[c];
            id[3 + c][lane] = q[c];
        }
    }
    Vectors first = LoadPoints(a->points, id[0]);
    Lanes l = {.b = Subtract(LoadPoints(a->points, id[1]), first),
               .c = Subtract(LoadPoints(a->points, id[2]), first),
               .d = Subtract(TransformPoints(bound, LoadPoints(b->points, id[3])), first),
               .e = Subtract(TransformPoints(bound, LoadPoints(b->points, id[4])), first),
               .f = Subtract(TransformPoints(bound, LoadPoints(b->points, id[5])), first)};
    Floats size = MaxFloats(MaxFloats(MaxAbsolute(l.b), MaxAbsolute(l.c)),
                            MaxFloats(MaxFloats(MaxAbsolute(l.d), MaxAbsolute(l.e)), MaxAbsolute(l.f)));
    // 2^-k for a size in [2^k, 2^(k+1)), by exponents: exact.
    Floats up = (Floats)(0x7f000000 - ((Ints)size & 0x7f800000));
    l.b = Times(l.b, up), l.c = Times(l.c, up), l.d = Times(l.d, up), l.e = Times(l.e, up), l.f = Times(l.f, up);
    l.up = up;
    l.error = bound->pointError * up;
    l.gap = (4.0f * bound->pointError + bound->query) * up * 1.0001f + 4e-6f;
    return l;
}

/// The planes of both triangles: what most pairs are apart by.
QC_INLINE Ints SeparatedByPlane(const Lanes* l)
{
    return Separates(l, Cross(l->b, l->c)) | Separates(l, Cross(Subtract(l->e, l->d), Subtract(l->f, l->d)));
}

/// The way from one middle to the other: what most triangles of one smooth surface are apart by that share no vertex.
QC_INLINE Ints SeparatedByCentroids(const Lanes* l)
{
    // Three times each; the first corner of A is 0.
    Vectors a = {l->b.x + l->c.x, l->b.y + l->c.y, l->b.z + l->c.z};
    Vectors b = {l->d.x + l->e.x + l->f.x, l->d.y + l->e.y + l->f.y, l->d.z + l->e.z + l->f.z};
    return Separates(l, Subtract(b, a));
}

/// Edges within the planes: what triangles are apart by that lie in one plane.
QC_INLINE Ints SeparatedWithinPlane(const Lanes* l)
{
    Vectors bc = Subtract(l->c, l->b), de = Subtract(l->e, l->d), df = Subtract(l->f, l->d), ef = Subtract(l->f, l->e);
    Vectors n = Cross(l->b, l->c), m = Cross(de, df);
    return Separates(l, Cross(n, l->b)) | Separates(l, Cross(n, l->c)) | Separates(l, Cross(n, bc)) |
           Separates(l, Cross(m, de)) | Separates(l, Cross(m, df)) | Separates(l, Cross(m, ef));
}

/// Pairs of edges; and, for triangles that lie in one plane, edges within it.
QC_INLINE Ints SeparatedByEdges(const Lanes* l)
{
    Vectors bc = Subtract(l->c, l->b), de = Subtract(l->e, l->d), df = Subtract(l->f, l->d), ef = Subtract(l->f, l->e);
    Vectors edgeA[3] = {l->b, l->c, bc}, edgeB[3] = {de, df, ef};
    Ints apart = SeparatedWithinPlane(l);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            apart |= Separates(l, Cross(edgeA[i], edgeB[j]));
    return apart;
}

QC_INLINE Ints SeparatedByCentroidsOrPlane(const Lanes* l)
{
    return SeparatedByCentroids(l) | SeparatedByPlane(l);
}

typedef Ints Separated(const Lanes* l);

QC_INLINE size_t KeepUnseparated(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                                 const qcDistanceThresholds* bound, qcSlotPair* pairs, size_t count,
                                 Separated* separated)
{
    size_t kept = 0;
    for (size_t at = 0; at < count; at += QC_LANES)
    {
        size_t left = count - at < QC_LANES ? count - at : QC_LANES;
        Lanes lanes = LoadLanes(a, b, bound, pairs + at, left);
        uint32_t stay = ~SignBits(separated(&lanes)) & (uint32_t)((UINT64_C(1) << left) - 1);
        for (; stay != 0; stay &= stay - 1)
            pairs[kept++] = pairs[at + (size_t)__builtin_ctz(stay)];
    }
    return kept;
}

static size_t Filter(const qcIndexedTriangles* a, const qcIndexedTriangles* b, const qcDistanceThresholds* bound,
                     qcSlotPair* pairs, size_t count)
{
    // Most that come within a reach are of one smooth surface, most others lie in layers. What stays is measured
    // (kernels/triangle_distance.inl.h), which takes no longer than more axes would.
    if (bound->query > 0.0f)
        return KeepUnseparated(a, b, bound, pairs, count, SeparatedByCentroidsOrPlane);
    count = KeepUnseparated(a, b, bound, pairs, count, SeparatedByPlane);
    return KeepUnseparated(a, b, bound, pairs, count, SeparatedByEdges);
}

//  ---- sure hits -----------------------------------------------------------------------------------

/// Of a determinant: where it is surely above 0, where below.
typedef struct Signs
{
    Ints above, below;
} Signs;

QC_INLINE Floats SumOfAbsolutes(Vectors a)
{
    return Absolute(a.x) + Absolute(a.y) + Absolute(a.z);
}

/// The sign of u . (v x w), each of which is wrong by `error` in each coordinate.
QC_INLINE Signs SignOf(Vectors u, Vectors v, Vectors w, Floats error)
{
    Vectors vw = Cross(v, w);
    Floats x = Dot(u, vw);
    Floats size = SumOfAbsolutes(vw) + SumOfAbsolutes(Cross(w, u)) + SumOfAbsolutes(Cross(u, v));
    Floats bound = error * (1.001f * size + 100.0f * error) + 1.2e-4f;
    return (Signs){x > bound, x < -bound};
}

QC_INLINE Ints HaveSameSign(Signs a, Signs b, Signs c)
{
    return (a.above & b.above & c.above) | (a.below & b.below & c.below);
}

QC_INLINE Ints HaveOppositeSigns(Signs a, Signs b)
{
    return (a.above & b.below) | (a.below & b.above);
}

/// Where an edge of one goes through the other: from one side of its plane to the other, within all three edges.
QC_INLINE Ints Intersects(const Lanes* l)
{
    const Floats zero = {0};
    const Vectors origin = {zero, zero, zero};
    Floats error = 4.0f * l->error + 3.0f * 0x1p-22f;
    Vectors a[3] = {origin, l->b, l->c}, b[3] = {l->d, l->e, l->f};
    Vectors de = Subtract(l->e, l->d), df = Subtract(l->f, l->d);
    Signs ofA[3], ofB[3], side[3][3];
    for (int i = 0; i < 3; i++)
    {
        ofA[i] = SignOf(Subtract(a[i], l->d), de, df, error);
        ofB[i] = SignOf(b[i], l->b, l->c, error);
        // On which side the line through one edge passes the other.
        for (int k = 0; k < 3; k++)
            side[i][k] =
                SignOf(Subtract(a[(i + 1) % 3], a[i]), Subtract(b[k], a[i]), Subtract(b[(k + 1) % 3], a[i]), error);
    }
    Ints pierces = {0};
    for (int i = 0; i < 3; i++)
    {
        pierces |= HaveSameSign(side[0][i], side[1][i], side[2][i]) & HaveOppositeSigns(ofB[i], ofB[(i + 1) % 3]);
        pierces |= HaveSameSign(side[i][0], side[i][1], side[i][2]) & HaveOppositeSigns(ofA[i], ofA[(i + 1) % 3]);
    }
    return pierces;
}

static size_t FindIntersecting(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                               const qcDistanceThresholds* bound, qcSlotPair* pairs, size_t count)
{
    size_t found = 0;
    for (size_t at = 0; at < count; at += QC_LANES)
    {
        size_t left = count - at < QC_LANES ? count - at : QC_LANES;
        Lanes lanes = LoadLanes(a, b, bound, pairs + at, left);
        uint32_t hits = SignBits(Intersects(&lanes)) & (uint32_t)((UINT64_C(1) << left) - 1);
        for (; hits != 0; hits &= hits - 1)
        {
            size_t i = at + (size_t)__builtin_ctz(hits);
            qcSlotPair pair = pairs[i];
            pairs[i] = pairs[found];
            pairs[found++] = pair;
        }
    }
    return found;
}

#endif
