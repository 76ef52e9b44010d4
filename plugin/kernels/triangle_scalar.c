// Kernels in plain C, for any CPU. The vectors are the compiler's.
#include "kernels/triangle_kernels.h"

enum
{
    QC_LANES = 4
};

typedef int16_t Shorts __attribute__((vector_size(16)));
typedef float FourFloats __attribute__((vector_size(16)));
typedef int32_t FourInts __attribute__((vector_size(16)));

static inline Shorts MinShorts(Shorts a, Shorts b)
{
    Shorts less = a < b;
    return (a & less) | (b & ~less);
}

typedef FourInts LaneMask;

static inline LaneMask AllLanes(void)
{
    return ~(LaneMask){0};
}

static inline LaneMask IsAbove(FourFloats a, FourFloats b)
{
    return a > b;
}

static inline uint32_t LaneBits(LaneMask lanes)
{
    return (uint32_t)((lanes[0] & 1) | (lanes[1] & 2) | (lanes[2] & 4) | (lanes[3] & 8));
}

static inline FourFloats MinFloats(FourFloats a, FourFloats b)
{
    FourInts less = a < b;
    return (FourFloats)(((FourInts)a & less) | ((FourInts)b & ~less));
}

static inline FourFloats SquareRoot(FourFloats a)
{
    return (FourFloats){__builtin_sqrtf(a[0]), __builtin_sqrtf(a[1]), __builtin_sqrtf(a[2]), __builtin_sqrtf(a[3])};
}

static inline FourFloats MaxFloats(FourFloats a, FourFloats b)
{
    FourInts less = a < b;
    return (FourFloats)(((FourInts)b & less) | ((FourInts)a & ~less));
}

static inline void Transpose(const Shorts row[8], Shorts column[8])
{
    for (int i = 0; i < 8; i++)
        column[i] = (Shorts){row[0][i], row[1][i], row[2][i], row[3][i], row[4][i], row[5][i], row[6][i], row[7][i]};
}

typedef struct Position
{
    double x[3];
} Position;

static inline Position LoadDoublePosition(const double* x)
{
    return (Position){{x[0], x[1], x[2]}};
}

static inline Position LoadFloatPosition(const float* x)
{
    return (Position){{(double)x[0], (double)x[1], (double)x[2]}};
}

static inline Position MinPositions(Position a, Position b)
{
    for (int axis = 0; axis < 3; axis++)
        a.x[axis] = a.x[axis] < b.x[axis] ? a.x[axis] : b.x[axis];
    return a;
}

static inline Position MaxPositions(Position a, Position b)
{
    for (int axis = 0; axis < 3; axis++)
        a.x[axis] = a.x[axis] > b.x[axis] ? a.x[axis] : b.x[axis];
    return a;
}

static inline void StorePoint(const qcLatticeTransform* lattice, Position position, qcPoint* point)
{
    for (int axis = 0; axis < 3; axis++)
        point->x[axis] = (float)((position.x[axis] - lattice->origin[axis]) * lattice->unit[axis]);
    point->x[3] = 0.0f;
}

/// Truncated. With outliers, beyond the lattice it is the first level or the last.
static inline int32_t ToLevel(double scaled, bool hasOutliers)
{
    double level = scaled > 0.0 || !hasOutliers ? scaled : 0.0;
    return (int32_t)(level < qc_lastLevel || !hasOutliers ? level : qc_lastLevel) - 32768;
}

/// The levels of two positions, the second one with the margin.
static inline void StoreRow(const qcLatticeTransform* lattice, Position first, Position last, bool hasMargin,
                            bool hasOutliers, qcBoxRow* row)
{
    *row = (qcBoxRow){{0}};
    for (int axis = 0; axis < 3; axis++)
    {
        double lower = first.x[axis] - lattice->origin[axis],
               end = hasMargin ? last.x[axis] + lattice->margin[axis] : last.x[axis],
               upper = end - lattice->origin[axis];
        row->ends[axis] = (int16_t)ToLevel(lower * lattice->scale[axis], hasOutliers);
        row->ends[axis + 4] = (int16_t)~ToLevel(upper * lattice->scale[axis], hasOutliers);
    }
}

/// A bit for each lane of -1.
static inline uint32_t ToBits(Shorts lanes)
{
    const Shorts weights = {1, 2, 4, 8, 16, 32, 64, 128};
    Shorts bits = lanes & weights;
    return (uint32_t)(bits[0] + bits[1] + bits[2] + bits[3] + bits[4] + bits[5] + bits[6] + bits[7]);
}

/// One box of b at a time, against all boxes of a.
static inline uint64_t FindBoxOverlaps(const qcBox8* a, const qcBox8* b)
{
    Shorts lower[3], upper[3];
    for (int axis = 0; axis < 3; axis++)
    {
        __builtin_memcpy(&lower[axis], a->ends[axis], sizeof(Shorts));
        __builtin_memcpy(&upper[axis], a->ends[axis] + qc_boxLanes, sizeof(Shorts));
    }
    uint64_t overlaps = 0;
    for (int j = 0; j < qc_boxLanes; j++)
    {
        Shorts disjoint = {0};
        for (int axis = 0; axis < 3; axis++)
        {
            int16_t lowerB = b->ends[axis][j], upperB = b->ends[axis][qc_boxLanes + j];
            disjoint |= (lower[axis] > (int16_t)~upperB) | (upper[axis] > (int16_t)~lowerB);
        }
        overlaps |= (uint64_t)ToBits(~disjoint) << 8 * j;
    }
    return overlaps;
}

/// Bit i: box i overlaps the one of the row.
static inline uint32_t FindRowOverlaps(const qcBox8* boxes, const qcBoxRow* row)
{
    Shorts disjoint = {0};
    for (int axis = 0; axis < 3; axis++)
    {
        Shorts lower, upper;
        __builtin_memcpy(&lower, boxes->ends[axis], sizeof lower);
        __builtin_memcpy(&upper, boxes->ends[axis] + qc_boxLanes, sizeof upper);
        disjoint |= (lower > (int16_t)~row->ends[axis + 4]) | (upper > (int16_t)~row->ends[axis]);
    }
    return ToBits(~disjoint);
}

/// The boxes around both ends.
static inline uint64_t FindUnitedOverlaps(const qcBox8* const a[2], const qcBox8* const b[2])
{
    qcBox8 united[2];
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < 2 * qc_boxLanes; i++)
        {
            united[0].ends[axis][i] = a[a[1]->ends[axis][i] < a[0]->ends[axis][i]]->ends[axis][i];
            united[1].ends[axis][i] = b[b[1]->ends[axis][i] < b[0]->ends[axis][i]]->ends[axis][i];
        }
    return FindBoxOverlaps(&united[0], &united[1]);
}

/// An axis separates a motion if it separates in the same order at both ends.
static inline uint64_t FindMotionBoxOverlaps(const qcBox8* const a[2], const qcBox8* const b[2])
{
    uint64_t overlaps = 0;
    for (int j = 0; j < qc_boxLanes; j++)
    {
        Shorts disjoint = {0};
        for (int axis = 0; axis < 3; axis++)
        {
            Shorts above = ~(Shorts){0}, below = above;
            for (int t = 0; t < 2; t++)
            {
                Shorts lower, upper;
                __builtin_memcpy(&lower, a[t]->ends[axis], sizeof(Shorts));
                __builtin_memcpy(&upper, a[t]->ends[axis] + qc_boxLanes, sizeof(Shorts));
                above &= lower > (int16_t)~b[t]->ends[axis][qc_boxLanes + j];
                below &= upper > (int16_t)~b[t]->ends[axis][j];
            }
            disjoint |= above | below;
        }
        overlaps |= (uint64_t)ToBits(~disjoint) << 8 * j;
    }
    return overlaps;
}

//  ---- kernels/lattice_transform.inl.h -------------------------------------------------------------

typedef float EightFloats __attribute__((vector_size(32)));
typedef int32_t EightInts __attribute__((vector_size(32)));

static inline EightFloats LoadEnds(const int16_t* ends)
{
    Shorts loaded;
    __builtin_memcpy(&loaded, ends, sizeof loaded);
    return __builtin_convertvector(loaded, EightFloats);
}

static inline EightFloats SelectEight(EightInts mask, EightFloats yes, EightFloats no)
{
    return (EightFloats)((mask & (EightInts)yes) | (~mask & (EightInts)no));
}

static inline void StoreEnds(EightFloats lower, EightFloats upper, const int16_t source[qc_boxLanes], int axis,
                             qcBox8* transformed)
{
    const EightFloats zero = {0}, largest = zero + (float)qc_lastLevel;
    lower = SelectEight(lower > zero, lower, zero);
    lower = SelectEight(lower < largest, lower, largest);
    upper = SelectEight(upper < largest, upper, largest);
    upper = SelectEight(upper > zero, upper, zero);
    EightInts ends[2] = {__builtin_convertvector(lower, EightInts) - 32768,
                         32767 - __builtin_convertvector(upper, EightInts)};
    Shorts first, empty;
    __builtin_memcpy(&first, source, sizeof first);
    empty = first == qc_emptyEnd;
    for (size_t k = 0; k < 2; k++)
    {
        Shorts stored = __builtin_convertvector(ends[k], Shorts);
        stored = (stored & ~empty) | (first & empty);
        __builtin_memcpy(transformed->ends[axis] + k * qc_boxLanes, &stored, sizeof stored);
    }
}

//  ---- kernels/cluster_planes.inl.h ----------------------------------------------------------------

enum
{
    qc_planeLanes = 4
};

typedef FourFloats PlaneFloats;
typedef FourInts PlaneInts;

static inline PlaneFloats MinPlane(PlaneFloats a, PlaneFloats b)
{
    return MinFloats(a, b);
}

static inline PlaneFloats MaxPlane(PlaneFloats a, PlaneFloats b)
{
    return MaxFloats(a, b);
}

static inline uint32_t ToSignBits(FourInts lanes)
{
    return (uint32_t)((lanes[0] & 1) | (lanes[1] & 2) | (lanes[2] & 4) | (lanes[3] & 8));
}

static inline uint32_t FindApart(const PlaneFloats x[3], PlaneFloats lower, PlaneFloats upper)
{
    return ToSignBits(((x[0] > upper) & (x[1] > upper) & (x[2] > upper)) |
                      ((x[0] < lower) & (x[1] < lower) & (x[2] < lower)));
}

static inline void StoreShorts(PlaneFloats whole, int16_t* shorts)
{
    for (int i = 0; i < qc_planeLanes; i++)
        shorts[i] = (int16_t)whole[i];
}

static inline void LoadPlanePoints(const qcPoint* points, const qcCorners* corners, int corner, PlaneFloats out[4])
{
    const float *a = points[corners[0].vertex[corner]].x, *b = points[corners[1].vertex[corner]].x,
                *c = points[corners[2].vertex[corner]].x, *d = points[corners[3].vertex[corner]].x;
    for (int k = 0; k < 4; k++)
        out[k] = (PlaneFloats){a[k], b[k], c[k], d[k]};
}

static inline PlaneFloats PickLanes(const float lanes[8], PlaneInts at)
{
    return (PlaneFloats){lanes[at[0]], lanes[at[1]], lanes[at[2]], lanes[at[3]]};
}

static inline PlaneInts LoadNumbers(const uint8_t bytes[4])
{
    return (PlaneInts){bytes[0], bytes[1], bytes[2], bytes[3]};
}

static inline qcSlotPair* AddListed(uint32_t kept, const uint8_t listed[4], qcSlotPair first, qcSlotPair* pairs)
{
    for (; kept != 0; kept &= kept - 1)
    {
        uint32_t at = listed[__builtin_ctz(kept)];
        *pairs++ = (qcSlotPair){first.a + at % 8, first.b + at / 8};
    }
    return pairs;
}

#include "kernels/triangle_kernels.inl.h"

QC_INLINE Vectors LoadPoints(const qcPoint* points, const uint32_t vertex[QC_LANES])
{
    const float *a = points[vertex[0]].x, *b = points[vertex[1]].x, *c = points[vertex[2]].x, *d = points[vertex[3]].x;
    return (Vectors){{a[0], b[0], c[0], d[0]}, {a[1], b[1], c[1], d[1]}, {a[2], b[2], c[2], d[2]}};
}

QC_INLINE uint32_t SignBits(Ints lanes)
{
    return ToSignBits(lanes);
}

/// One triangle of b at a time, against all of a.
static inline uint64_t FindCommonVertices(const qcClusterVertices* a, const qcClusterVertices* b)
{
    FourInts corner[3][2];
    uint64_t common = 0;
    __builtin_memcpy(corner, a->vertex, sizeof corner);
    for (int v = 0; v < qc_clusterSize; v++)
    {
        FourInts equal[2] = {{0}, {0}};
        for (int k = 0; k < 3; k++)
        {
            int32_t one = (int32_t)b->vertex[k][v];
            FourInts vertex = {one, one, one, one};
            for (int half = 0; half < 2; half++)
                equal[half] |= (corner[0][half] == vertex) | (corner[1][half] == vertex) | (corner[2][half] == vertex);
        }
        FourInts bits = (equal[0] & (FourInts){1, 2, 4, 8}) | (equal[1] & (FourInts){16, 32, 64, 128});
        uint64_t halves[2];
        __builtin_memcpy(halves, &bits, sizeof halves);
        uint64_t any = halves[0] | halves[1];
        common |= (uint64_t)(uint8_t)(any | any >> 32) << 8 * v;
    }
    return common;
}

const qcTriangleKernels qcTriangleKernels_scalar = QC_KERNELS("plain");
