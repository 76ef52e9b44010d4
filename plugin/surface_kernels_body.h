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
//
// Sure hits. An edge whose ends are on different sides of a triangle's plane, and whose line passes all three edges on
// the same side, goes through the inside of the triangle: the two penetrate. Each sign is that of a determinant of
// differences u, v, w of corners, below 4 in each coordinate, wrong by h = 4 e s + 3 * 2^-22. To first order that
// changes the determinant by h (|v x w|_1 + |w x u|_1 + |u x v|_1), and by less than 73 h^2 more; crosses are computed
// to 2^-18, which 80 h^2 and the constant cover; rounding adds at most 1792 * 2^-24.
//
// Flat discs. The disc is a triangulation D of a closed disc (discs.h); f projects it along a direction d. If every
// triangle's image has the same orientation and the image of the loop is a simple curve, then f is injective:
// - The images of the oriented triangles add up to a chain whose boundary is the image of the loop, since inner edges
//   cancel. So a point off all edges lies in as many images as the loop winds around it: for a simple curve 0 or 1.
// - Suppose f(p) = f(q) with p != q. On the loop f is injective; so p, say, is inside. There f is open: in a triangle
// and
//   on an edge between two that is plain; around a vertex the images go round it once, as going round more often would
//   cover points nearby more than once. So f of a neighbourhood of p holds a neighbourhood of f(q); any neighbourhood
//   of q has a part of a triangle whose image is near f(q): points there are covered twice. A contradiction.
// Where two triangles of D have a common point in space, that is one point of D by this, in both triangles: they share
// a vertex. The normals alone don't do: a spiral ramp faces one way everywhere, and its contour crosses itself.
// (Volino, Magnenat-Thalmann: Efficient Self-Collision Detection on Smoothly Discretized Surface Animations, 1994.)
//
// Rounding there. Points are wrong by e, and d = (p, q, 1) with |p|, |q| <= 1 is exact: whatever it is will do. With
// edges up to m in any coordinate, a triangle's normal is wrong by 8 e m + 8 m^2 2^-24 + 8 e^2, and times d, rounded,
// by 24 e m + 38 m^2 2^-24 + 24 e^2. The kernel asks for 32 e m + 44 m^2 2^-24: no less where m >= 3 e, and below that
// more than there can be, 6 m^2. The loop is taken relative to one point, in coordinates up to 1: u and v are wrong by
// D = 2 e + 4 * 2^-24. With M twice the greatest of them, products of two differences of them, and what is made of two
// such products, are wrong by 8 M D + 8 M^2 2^-24 + 8 D^2. For M <= 4 the bound of IsSimple is no less where M >= 6 D,
// and below that more than there can be. Triangles without area never pass.
#ifndef QC_PLUGIN_SURFACE_KERNELS_BODY_H
#define QC_PLUGIN_SURFACE_KERNELS_BODY_H

#include "clusters.h"
#include "surface_kernels.h"

#include <math.h>
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

/// The pairs of a word that a skip of these two clusters leaves.
QC_INLINE uint64_t Leave(uint64_t word, const qcPlaceSkip* skip, uint32_t i, uint32_t j)
{
    unsigned a = (unsigned)(skip->a >> qc_clusterSize * i) & 0xffu,
             b = (unsigned)(skip->b >> qc_clusterSize * j) & 0xffu;
    // Bit v of b to bit 8 v: seven bits by one multiplication, without carries; then a copy of a at each.
    uint64_t spread = ((b & 0x7fu) * UINT64_C(0x0002040810204081) & UINT64_C(0x0001010101010101)) | (uint64_t)(b >> 7)
                                                                                                        << 56;
    return word & ~(spread * a);
}

static qcPlacePair* Collect(const qcSurfaceBoxes* a, uint32_t nodeA, const qcSurfaceBoxes* b, uint32_t nodeB,
                            const uint64_t* words, const qcPlaceSkip* skips, int skipCount, qcPlacePair* pairs)
{
    uint64_t clusters = CompareGroups(&a->nodes[nodeA], &b->nodes[nodeB]);
    for (; clusters != 0; clusters &= clusters - 1)
    {
        uint32_t bit = (uint32_t)__builtin_ctzll(clusters);
        uint64_t word = words != NULL ? words[bit] : UINT64_MAX;
        for (int i = 0; i < skipCount; i++)
            word = Leave(word, &skips[i], bit % qc_groupSize, bit / qc_groupSize);
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
    Floats error; ///< of a coordinate, before they were taken relative to another
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
    l.error = bound->pointError * up;
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

//  ---- sure hits -----------------------------------------------------------------------------------

/// Of a determinant: where it is surely above 0, where below.
typedef struct Signs
{
    Ints above, below;
} Signs;

QC_INLINE Floats SumOfSizes(Vectors a)
{
    return Absolute(a.x) + Absolute(a.y) + Absolute(a.z);
}

/// The sign of u . (v x w), each of which is wrong by `error` in each coordinate.
QC_INLINE Signs SignOf(Vectors u, Vectors v, Vectors w, Floats error)
{
    Vectors vw = Cross(v, w);
    Floats x = Dot(u, vw);
    Floats size = SumOfSizes(vw) + SumOfSizes(Cross(w, u)) + SumOfSizes(Cross(u, v));
    Floats bound = error * (1.001f * size + 100.0f * error) + 1.2e-4f;
    return (Signs){x > bound, x < -bound};
}

QC_INLINE Ints AllAlike(Signs a, Signs b, Signs c)
{
    return (a.above & b.above & c.above) | (a.below & b.below & c.below);
}

QC_INLINE Ints AreOpposite(Signs a, Signs b)
{
    return (a.above & b.below) | (a.below & b.above);
}

/// Where an edge of one goes through the other: from one side of its plane to the other, within all three edges.
QC_INLINE Ints Pierces(const Lanes* l)
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
        pierces |= AllAlike(side[0][i], side[1][i], side[2][i]) & AreOpposite(ofB[i], ofB[(i + 1) % 3]);
        pierces |= AllAlike(side[i][0], side[i][1], side[i][2]) & AreOpposite(ofA[i], ofA[(i + 1) % 3]);
    }
    return pierces;
}

static size_t FindPiercing(const qcFilterSide* a, const qcFilterSide* b, const qcFilterBound* bound, qcPlacePair* pairs,
                           size_t count)
{
    size_t found = 0;
    for (size_t at = 0; at < count; at += QC_LANES)
    {
        size_t left = count - at < QC_LANES ? count - at : QC_LANES;
        Lanes lanes = LoadLanes(a, b, bound, pairs + at, left);
        uint32_t hits = SignBits(Pierces(&lanes)) & (uint32_t)((UINT64_C(1) << left) - 1);
        for (; hits != 0; hits &= hits - 1)
        {
            size_t i = at + (size_t)__builtin_ctz(hits);
            qcPlacePair pair = pairs[i];
            pairs[i] = pairs[found];
            pairs[found++] = pair;
        }
    }
    return found;
}

//  ---- flat discs ----------------------------------------------------------------------------------

enum
{
    qc_arcEdges = 4
};

/// The loop around a disc from its centre, seen along d = (p, q, 1) in some order of the axes.
typedef struct Loop
{
    float u[qc_mostLoop + 2 * QC_LANES], v[qc_mostLoop + 2 * QC_LANES];
    float x[3][qc_mostLoop + 2 * QC_LANES];
    int axes[3]; ///< which axis is which of d's; the last is 1 there
    float p, q;
    float sign; ///< of d's last axis in the direction that the disc faces
    float size; ///< of the greatest coordinate u or v
} Loop;

QC_INLINE Floats LoadFloats(const float* from)
{
    Floats f;
    memcpy(&f, from, sizeof f);
    return f;
}

QC_INLINE void StoreFloats(float* to, Floats f)
{
    memcpy(to, &f, sizeof f);
}

QC_INLINE float Sum(Floats f)
{
    float sum = 0.0f;
    for (int i = 0; i < QC_LANES; i++)
        sum += f[i];
    return sum;
}

/// Past the end the loop goes on from its beginning.
static void LoadLoop(const qcFlatDisc* disc, Loop* loop)
{
    size_t count = disc->loopCount;
    uint32_t id[qc_mostLoop + 2 * QC_LANES];
    memcpy(id, disc->loop, count * sizeof id[0]);
    for (size_t i = count; i < count + 2 * QC_LANES; i++)
        id[i] = id[i - count];
    const float* centre = disc->points[id[0]].x;
    const float* opposite = disc->points[id[count / 2]].x;
    Floats at[3] = {{0}};
    for (int axis = 0; axis < 3; axis++)
        at[axis] += 0.5f * (centre[axis] + opposite[axis]);
    for (size_t i = 0; i < count + QC_LANES; i += QC_LANES)
    {
        Vectors point = LoadPoints(disc->points, id + i);
        StoreFloats(loop->x[0] + i, point.x - at[0]);
        StoreFloats(loop->x[1] + i, point.y - at[1]);
        StoreFloats(loop->x[2] + i, point.z - at[2]);
    }
}

/// Twice the area that the loop spans, as a vector: its direction is where the disc faces. False: there is none.
static bool ChooseDirection(size_t count, Loop* loop)
{
    float area[3];
    for (int axis = 0; axis < 3; axis++)
    {
        const float *y = loop->x[(axis + 1) % 3], *z = loop->x[(axis + 2) % 3];
        Floats sum = {0};
        for (size_t i = 0; i < count; i += QC_LANES)
        {
            Floats part = LoadFloats(y + i) * LoadFloats(z + i + 1) - LoadFloats(z + i) * LoadFloats(y + i + 1);
            for (size_t lane = count - i; lane < QC_LANES; lane++)
                part[lane] = 0.0f;
            sum += part;
        }
        area[axis] = Sum(sum);
    }
    int last = 0;
    for (int axis = 1; axis < 3; axis++)
        if (__builtin_fabsf(area[axis]) > __builtin_fabsf(area[last]))
            last = axis;
    if (!(__builtin_fabsf(area[last]) > 0.0f))
        return false;
    loop->axes[0] = (last + 1) % 3;
    loop->axes[1] = (last + 2) % 3;
    loop->axes[2] = last;
    loop->p = area[loop->axes[0]] / area[last];
    loop->q = area[loop->axes[1]] / area[last];
    loop->sign = area[last] > 0.0f ? 1.0f : -1.0f;
    return true;
}

/// The loop as it is seen along d.
static void Project(size_t count, Loop* loop)
{
    const float *x = loop->x[loop->axes[0]], *y = loop->x[loop->axes[1]], *z = loop->x[loop->axes[2]];
    Floats largest = {0};
    for (size_t i = 0; i < count + QC_LANES; i += QC_LANES)
    {
        Floats depth = LoadFloats(z + i), u = LoadFloats(x + i) - loop->p * depth,
               v = LoadFloats(y + i) - loop->q * depth;
        largest = MostFloats(largest, MostFloats(Absolute(u), Absolute(v)));
        StoreFloats(loop->u + i, u);
        StoreFloats(loop->v + i, v);
    }
    loop->size = 0.0f;
    for (int lane = 0; lane < QC_LANES; lane++)
        loop->size = largest[lane] > loop->size ? largest[lane] : loop->size;
}

/// Are both ends of edge k surely on the same side of edge i: of the line through it, or of one of the two across it at
/// its ends?
static bool IsOneSided(const Loop* loop, size_t i, size_t k, float least)
{
    float u = loop->u[i], v = loop->v[i], endU = loop->u[i + 1], endV = loop->v[i + 1];
    float alongU = endU - u, alongV = endV - v, left[2], beyond[2], before[2];
    for (size_t end = 0; end < 2; end++)
    {
        float otherU = loop->u[k + end], otherV = loop->v[k + end];
        left[end] = alongU * (otherV - v) - alongV * (otherU - u);
        beyond[end] = alongU * (otherU - endU) + alongV * (otherV - endV);
        before[end] = alongU * (u - otherU) + alongV * (v - otherV);
    }
    return (left[0] > least && left[1] > least) || (left[0] < -least && left[1] < -least) ||
           (beyond[0] > least && beyond[1] > least) || (before[0] > least && before[1] > least);
}

/// Do edges i and k meet at most where they join?
static bool AreEdgesApart(const Loop* loop, size_t count, size_t i, size_t k, float least)
{
    if (k == (i + 1) % count || i == (k + 1) % count)
    {
        // An edge that turns back could lie on the one before.
        size_t first = k == (i + 1) % count ? i : k;
        float u = loop->u[first + 1] - loop->u[first], v = loop->v[first + 1] - loop->v[first];
        float nextU = loop->u[first + 2] - loop->u[first + 1], nextV = loop->v[first + 2] - loop->v[first + 1];
        float turn = u * nextV - v * nextU, ahead = u * nextU + v * nextV;
        return turn > least || turn < -least || ahead > least;
    }
    return IsOneSided(loop, i, k, least) || IsOneSided(loop, k, i, least);
}

/// Some edges that follow each other, and a box around them.
typedef struct Arc
{
    size_t first, end; ///< edges; the last vertex is `end`
    float lower[2], upper[2];
} Arc;

static bool AreArcsApart(const Loop* loop, size_t count, const Arc* a, const Arc* b, float least)
{
    for (size_t i = a->first; i < a->end; i++)
        for (size_t k = b->first; k < b->end; k++)
            if (i != k && !AreEdgesApart(loop, count, i, k, least))
                return false;
    return true;
}

/// Do all edges of two arcs, the one behind the other, go forward in one direction? Then none meets another.
static bool GoForward(const Loop* loop, const Arc* a, const Arc* b, float least)
{
    float u = loop->u[b->end] - loop->u[a->first], v = loop->v[b->end] - loop->v[a->first];
    float slowest = INFINITY;
    const Arc* arcs[2] = {a, b};
    for (int k = 0; k < 2; k++)
        for (size_t i = arcs[k]->first; i < arcs[k]->end; i++)
        {
            float step = u * (loop->u[i + 1] - loop->u[i]) + v * (loop->v[i + 1] - loop->v[i]);
            slowest = step < slowest ? step : slowest;
        }
    return slowest > least;
}

static Arc MakeArc(const Loop* loop, size_t first, size_t end)
{
    Arc arc = {first, end, {loop->u[first], loop->v[first]}, {loop->u[first], loop->v[first]}};
    for (size_t i = first + 1; i <= end; i++)
    {
        float at[2] = {loop->u[i], loop->v[i]};
        for (int axis = 0; axis < 2; axis++)
        {
            arc.lower[axis] = at[axis] < arc.lower[axis] ? at[axis] : arc.lower[axis];
            arc.upper[axis] = at[axis] > arc.upper[axis] ? at[axis] : arc.upper[axis];
        }
    }
    return arc;
}

/// Does no edge of the loop meet another but where they join? By arcs of a few edges.
static bool IsSimple(const qcFlatDisc* disc, const Loop* loop)
{
    size_t count = disc->loopCount, arcCount = (count + qc_arcEdges - 1) / qc_arcEdges;
    float least = (48.0f * disc->pointError + 160.0f * 0x1p-24f) * loop->size;
    float gap = 5.0f * disc->pointError + 10.0f * 0x1p-24f;
    Arc arcs[qc_mostLoop / qc_arcEdges];
    for (size_t a = 0; a < arcCount; a++)
    {
        size_t first = a * qc_arcEdges, end = first + qc_arcEdges < count ? first + qc_arcEdges : count;
        arcs[a] = MakeArc(loop, first, end);
    }
    for (size_t a = 0; a < arcCount; a++)
    {
        const Arc *arc = &arcs[a], *next = &arcs[(a + 1) % arcCount];
        if (!GoForward(loop, arc, next, least) &&
            !(AreArcsApart(loop, count, arc, arc, least) && AreArcsApart(loop, count, arc, next, least)))
            return false;
        for (size_t b = a + 2; b < arcCount; b++)
        {
            const Arc* other = &arcs[b];
            bool apart = arc->lower[0] > other->upper[0] + gap || other->lower[0] > arc->upper[0] + gap ||
                         arc->lower[1] > other->upper[1] + gap || other->lower[1] > arc->upper[1] + gap;
            if (!apart && (a != 0 || b != arcCount - 1) && !AreArcsApart(loop, count, arc, other, least))
                return false;
        }
    }
    return true;
}

/// Do all triangles face d's way?
static bool FacesOneWay(const qcFlatDisc* disc, const Loop* loop)
{
    for (size_t at = 0; at < disc->placeCount; at += QC_LANES)
    {
        size_t count = disc->placeCount - at < QC_LANES ? disc->placeCount - at : QC_LANES;
        uint32_t id[3][QC_LANES];
        for (size_t lane = 0; lane < QC_LANES; lane++)
        {
            const uint32_t* vertex = disc->corners[disc->places[at + (lane < count ? lane : 0)]].vertex;
            for (int c = 0; c < 3; c++)
                id[c][lane] = vertex[c];
        }
        Vectors first = LoadPoints(disc->points, id[0]);
        Vectors e = Subtract(LoadPoints(disc->points, id[1]), first);
        Vectors f = Subtract(LoadPoints(disc->points, id[2]), first);
        Vectors cross = Cross(e, f);
        Floats normal[3] = {cross.x, cross.y, cross.z}, size = MostFloats(Largest(e), Largest(f));
        Floats facing =
            (normal[loop->axes[0]] * loop->p + normal[loop->axes[1]] * loop->q + normal[loop->axes[2]]) * loop->sign;
        Floats least = size * (32.0f * disc->pointError + 44.0f * 0x1p-24f * size);
        if (SignBits(~(facing > least)) != 0)
            return false;
    }
    return true;
}

static bool IsFlat(const qcFlatDisc* disc)
{
    Loop loop;
    LoadLoop(disc, &loop);
    if (!ChooseDirection(disc->loopCount, &loop))
        return false;
    Project(disc->loopCount, &loop);
    return FacesOneWay(disc, &loop) && IsSimple(disc, &loop);
}

#define QC_KERNELS(title)                                                                                              \
    {                                                                                                                  \
        .name = title, .map = Map, .fitTriangles = FitTriangles, .fitGroups = FitGroups, .compare = Compare,           \
        .collect = Collect, .isFlat = IsFlat, .mapGroup = MapGroup, .collectMapped = CollectMapped, .filter = Filter,  \
        .findPiercing = FindPiercing                                                                                   \
    }

#endif
