// What the kernels have in common. The file of an instruction set defines, before it includes this one:
//
//   QC_LANES                   floats in a vector
//   Shorts                     eight int16_t
//   LeastShorts, LeastFloats, MostFloats
//   Transpose                  eight rows to eight columns
//   MapVertex                  one vertex
//   CompareGroups              as compare
//
// and after it:
//
//   LoadPoints                 QC_LANES points to three vectors
//   SignBits                   a bit for each lane that is true
//
// Filter. For any vector w, if the projections on w of all points of A and all points of B are further apart than
// r |w|, so are the triangles. Coordinates are wrong by at most e (pointError). They are taken relative to one vertex
// and scaled by a power of two s, exactly, so that the largest is in [1, 2): each is then wrong by 2 e s + 2^-22. An
// operation is taken to be right to one unit in the last place, fused or not. A product of three terms with w is wrong
// by at most |w|_1 (2 e s + 2^-22 + 4 * 2 * 2^-23), the difference of two such by twice that and its own rounding
// |w|_1 2^-21: together |w|_1 (4 e s + 2.9e-6). A gap of |w|_1 ((4 e + r) s 1.0001 + 4e-6) is asked for, and |w|_1 >=
// |w|. Axes shorter than 1e-20, where products could vanish, don't count. A triangle has its size from its corners: if
// all are one point, the scale is the greatest power of two, nothing is apart, and the pair stays.
#ifndef QC_PLUGIN_SURFACE_KERNELS_BODY_H
#define QC_PLUGIN_SURFACE_KERNELS_BODY_H

#include "clusters.h"
#include "surface_kernels.h"

#include <string.h>

#define QC_INLINE static inline __attribute__((always_inline))

//  ---- boxes ---------------------------------------------------------------------------------------

static void Map(const qcLatticeMap* map, const qcVertexRange* range, qcPoint* points, qcBoxRow* rows)
{
    for (size_t i = range->first; i < range->end; i++)
        MapVertex(map, range->positions + 3 * (size_t)range->vertexOf[i], &points[i], &rows[i]);
}

/// Eight rows side by side; returns the row around them.
QC_INLINE Shorts StoreGroup(const Shorts row[qc_groupSize], qcBoxGroup* group)
{
    Shorts column[8];
    Transpose(row, column);
    for (int axis = 0; axis < 3; axis++)
    {
        memcpy(group->ends[axis], &column[axis], sizeof(Shorts));
        memcpy(group->ends[axis] + qc_groupSize, &column[axis + 4], sizeof(Shorts));
    }
    return LeastShorts(LeastShorts(LeastShorts(row[0], row[1]), LeastShorts(row[2], row[3])),
                       LeastShorts(LeastShorts(row[4], row[5]), LeastShorts(row[6], row[7])));
}

QC_INLINE Shorts LoadRow(const qcBoxRow* row)
{
    Shorts ends;
    memcpy(&ends, row, sizeof ends);
    return ends;
}

static void FitTriangles(const qcCorners* corners, const qcBoxRow* vertices, size_t first, size_t end,
                         qcBoxGroup* groups, qcBoxRow* rows)
{
    for (size_t g = first; g < end; g++)
    {
        Shorts row[qc_groupSize];
        const qcCorners* c = corners + g * qc_groupSize;
        for (int i = 0; i < qc_groupSize; i++)
            row[i] = LeastShorts(LeastShorts(LoadRow(&vertices[c[i].vertex[0]]), LoadRow(&vertices[c[i].vertex[1]])),
                                 LoadRow(&vertices[c[i].vertex[2]]));
        Shorts around = StoreGroup(row, &groups[g]);
        memcpy(&rows[g], &around, sizeof around);
    }
}

static void FitGroups(const qcBoxRow* children, size_t first, size_t end, qcBoxGroup* groups, qcBoxRow* rows)
{
    for (size_t g = first; g < end; g++)
    {
        Shorts row[qc_groupSize];
        for (int i = 0; i < qc_groupSize; i++)
            row[i] = LoadRow(&children[g * qc_groupSize + i]);
        Shorts around = StoreGroup(row, &groups[g]);
        memcpy(&rows[g], &around, sizeof around);
    }
}

static uint64_t Compare(const qcBoxGroup* a, const qcBoxGroup* b)
{
    return CompareGroups(a, b);
}

/// Adds the triangles of two clusters that meet and whose bits are set.
QC_INLINE qcPlacePair* AddPairs(uint64_t triangles, size_t clusterA, size_t clusterB, qcPlacePair* pairs)
{
    uint32_t firstA = (uint32_t)clusterA * qc_clusterSize, firstB = (uint32_t)clusterB * qc_clusterSize;
    for (; triangles != 0; triangles &= triangles - 1)
    {
        uint32_t t = (uint32_t)__builtin_ctzll(triangles);
        *pairs++ = (qcPlacePair){firstA + t % qc_clusterSize, firstB + t / qc_clusterSize};
    }
    return pairs;
}

static qcPlacePair* Collect(const qcSurfaceBoxes* a, uint32_t nodeA, const qcSurfaceBoxes* b, uint32_t nodeB,
                            const uint64_t* words, qcPlacePair* pairs)
{
    uint64_t clusters = CompareGroups(&a->nodes[nodeA], &b->nodes[nodeB]);
    for (; clusters != 0; clusters &= clusters - 1)
    {
        uint32_t bit = (uint32_t)__builtin_ctzll(clusters);
        uint64_t word = words != NULL ? words[bit] : UINT64_MAX;
        if (word == 0)
            continue;
        size_t clusterA = (size_t)nodeA * qc_groupSize + bit % qc_groupSize;
        size_t clusterB = (size_t)nodeB * qc_groupSize + bit / qc_groupSize;
        pairs =
            AddPairs(CompareGroups(&a->clusters[clusterA], &b->clusters[clusterB]) & word, clusterA, clusterB, pairs);
    }
    return pairs;
}

/// From 0 to 65533; not a number is `unknown`.
QC_INLINE float Clamp(float level, float unknown)
{
    if (unknown == 0.0f)
    {
        level = level > 0.0f ? level : 0.0f;
        return level < 65533.0f ? level : 65533.0f;
    }
    level = level < 65533.0f ? level : 65533.0f;
    return level > 0.0f ? level : 0.0f;
}

/// A box with centre c and half extents e goes to one around linear c + shift, with |linear| e.
static void MapGroup(const qcBoxGroup* group, const qcGroupMap* map, qcBoxGroup* mapped)
{
    float centre[3][qc_groupSize], half[3][qc_groupSize];
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < qc_groupSize; i++)
        {
            // A level is an interval: up to where the next begins.
            int lower = group->ends[axis][i], end = ~group->ends[axis][qc_groupSize + i] + 1;
            centre[axis][i] = 0.5f * (float)(lower + end);
            half[axis][i] = 0.5f * (float)(end - lower);
        }
    for (int axis = 0; axis < 3; axis++)
    {
        const float* row = map->linear[axis];
        float size[3] = {__builtin_fabsf(row[0]), __builtin_fabsf(row[1]), __builtin_fabsf(row[2])};
        for (int i = 0; i < qc_groupSize; i++)
        {
            float at = row[0] * centre[0][i] + row[1] * centre[1][i] + row[2] * centre[2][i] + map->shift[axis];
            float around = size[0] * half[0][i] + size[1] * half[1][i] + size[2] * half[2][i] + map->grow[axis];
            int lower = (int)Clamp(at - around, 0.0f) - 32768, upper = (int)Clamp(at + around, 1.0f) - 32768;
            bool empty = group->ends[0][i] == qc_emptyEnd;
            mapped->ends[axis][i] = (int16_t)(empty ? qc_emptyEnd : lower);
            mapped->ends[axis][qc_groupSize + i] = (int16_t)(empty ? qc_emptyEnd : ~upper);
        }
    }
}

static qcPlacePair* CollectMapped(const qcSurfaceBoxes* a, uint32_t nodeA, const qcSurfaceBoxes* b, uint32_t nodeB,
                                  const qcGroupMap* map, qcPlacePair* pairs)
{
    qcBoxGroup mapped;
    MapGroup(&b->nodes[nodeB], map, &mapped);
    uint64_t clusters = CompareGroups(&a->nodes[nodeA], &mapped);
    for (uint32_t j = 0; j < qc_groupSize; j++)
    {
        uint32_t row = (uint32_t)(clusters >> qc_groupSize * j) & 0xffu;
        if (row == 0)
            continue;
        size_t clusterB = (size_t)nodeB * qc_groupSize + j;
        MapGroup(&b->clusters[clusterB], map, &mapped);
        for (; row != 0; row &= row - 1)
        {
            size_t clusterA = (size_t)nodeA * qc_groupSize + (uint32_t)__builtin_ctz(row);
            pairs = AddPairs(CompareGroups(&a->clusters[clusterA], &mapped), clusterA, clusterB, pairs);
        }
    }
    return pairs;
}

//  ---- filter --------------------------------------------------------------------------------------

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
    Floats gap;
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

QC_INLINE Floats Largest(Vectors a)
{
    return MostFloats(MostFloats(Absolute(a.x), Absolute(a.y)), Absolute(a.z));
}

/// Where the axis separates: all bits.
QC_INLINE Ints Separates(const Lanes* l, Vectors axis)
{
    const Floats zero = {0};
    Floats u = Dot(axis, l->b), v = Dot(axis, l->c), p = Dot(axis, l->d), q = Dot(axis, l->e), r = Dot(axis, l->f);
    Floats least = (Absolute(axis.x) + Absolute(axis.y) + Absolute(axis.z)) * l->gap;
    Floats above = LeastFloats(p, LeastFloats(q, r)) - MostFloats(zero, MostFloats(u, v));
    Floats below = LeastFloats(zero, LeastFloats(u, v)) - MostFloats(p, MostFloats(q, r));
    return (MostFloats(above, below) > least) & (MostFloats(above, below) > 1e-20f);
}

QC_INLINE Vectors MapPoints(const qcFilterBound* bound, Vectors p)
{
    if (!bound->mapped)
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
QC_INLINE Lanes LoadLanes(const qcFilterSide* a, const qcFilterSide* b, const qcFilterBound* bound,
                          const qcPlacePair* pairs, size_t count)
{
    uint32_t id[6][QC_LANES];
    for (size_t lane = 0; lane < QC_LANES; lane++)
    {
        qcPlacePair pair = pairs[lane < count ? lane : count - 1];
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
               .d = Subtract(MapPoints(bound, LoadPoints(b->points, id[3])), first),
               .e = Subtract(MapPoints(bound, LoadPoints(b->points, id[4])), first),
               .f = Subtract(MapPoints(bound, LoadPoints(b->points, id[5])), first)};
    Floats size = MostFloats(MostFloats(Largest(l.b), Largest(l.c)),
                             MostFloats(MostFloats(Largest(l.d), Largest(l.e)), Largest(l.f)));
    // 2^-k for a size in [2^k, 2^(k+1)), by exponents: exact.
    Floats up = (Floats)(0x7f000000 - ((Ints)size & 0x7f800000));
    l.b = Times(l.b, up), l.c = Times(l.c, up), l.d = Times(l.d, up), l.e = Times(l.e, up), l.f = Times(l.f, up);
    l.gap = (4.0f * bound->pointError + bound->reach) * up * 1.0001f + 4e-6f;
    return l;
}

/// The planes of both triangles: what most pairs are apart by.
QC_INLINE Ints SeparatedByPlane(const Lanes* l)
{
    return Separates(l, Cross(l->b, l->c)) | Separates(l, Cross(Subtract(l->e, l->d), Subtract(l->f, l->d)));
}

/// Pairs of edges; and, for triangles that lie in a plane, edges within it.
QC_INLINE Ints SeparatedByEdges(const Lanes* l)
{
    Vectors bc = Subtract(l->c, l->b), de = Subtract(l->e, l->d), df = Subtract(l->f, l->d), ef = Subtract(l->f, l->e);
    Vectors edgeA[3] = {l->b, l->c, bc}, edgeB[3] = {de, df, ef}, n = Cross(l->b, l->c), m = Cross(de, df);
    Ints apart = {0};
    for (int i = 0; i < 3; i++)
    {
        for (int j = 0; j < 3; j++)
            apart |= Separates(l, Cross(edgeA[i], edgeB[j]));
        apart |= Separates(l, Cross(n, edgeA[i])) | Separates(l, Cross(m, edgeB[i]));
    }
    return apart;
}

typedef Ints Separated(const Lanes* l);

QC_INLINE size_t Keep(const qcFilterSide* a, const qcFilterSide* b, const qcFilterBound* bound, qcPlacePair* pairs,
                      size_t count, Separated* separated)
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

static size_t Filter(const qcFilterSide* a, const qcFilterSide* b, const qcFilterBound* bound, qcPlacePair* pairs,
                     size_t count)
{
    count = Keep(a, b, bound, pairs, count, SeparatedByPlane);
    return Keep(a, b, bound, pairs, count, SeparatedByEdges);
}

#define QC_KERNELS(title)                                                                                              \
    {                                                                                                                  \
        .name = title, .map = Map, .fitTriangles = FitTriangles, .fitGroups = FitGroups, .compare = Compare,           \
        .collect = Collect, .mapGroup = MapGroup, .collectMapped = CollectMapped, .filter = Filter                     \
    }

#endif
