// Two triangles with snapped coordinates, at rest and in motion: predicates, relation, distance, segment, proximity and
// certificates against rational arithmetic.
#include "fuzz/fuzz.h"
#include "support/oracle.h"
#include "triangle/exact.h"
#include "triangle/motion_claims.h"
#include "triangle/motion_in_parts.h"
#include "triangle/pair_claims.h"

#include <float.h>

/// What one input checks: one claim, so that cheap ones run often.
typedef enum Claim
{
    qc_claimRelation,
    qc_claimOrientation,
    qc_claimWithin,
    qc_claimSegment,
    qc_claimProximity,
    qc_claimMotion,
    qc_claimParts,
    qc_claimNeighbours,
    qc_claimCount
} Claim;

//  ---- corners from bytes ------------------------------------------------------------------------------------------

/// A world of coordinates: integers up to `range`, later scaled by powers of two, one for each axis.
typedef struct Space
{
    double range;
    int exponents[3];
    bool isLattice; ///< all coordinates are integers times the scale, of at most 40 bits
} Space;

static Space TakeSpace(FuzzBytes* bytes)
{
    static const double ranges[] = {1.0, 2.0, 4.0, 16.0, 1000.0, 0x1p20, 0x1p23, 0x1p30};
    static const int exponents[] = {0, -20, 40, -1074, -1060, -1022, -540, 510, 900, 970};
    Space space = {ranges[Fuzz_TakeBelow(bytes, 8)], {0, 0, 0}, true};
    uint8_t way = Fuzz_TakeByte(bytes);
    for (int axis = 0; axis < 3; axis++)
        // Mostly one scale for all axes.
        space.exponents[axis] = axis > 0 && way % 4 != 3
                                    ? space.exponents[0]
                                    : exponents[axis == 0 ? way / 4 % 10 : Fuzz_TakeBelow(bytes, 10)];
    return space;
}

static double TakeCoordinate(FuzzBytes* bytes, const Space* space)
{
    double range = space->range;
    if (range <= 16.0)
        return (double)Fuzz_TakeBelow(bytes, 2 * (uint32_t)range + 1) - range;
    return floor(range * ((double)(int32_t)(Fuzz_TakeBits(bytes, 4) & 0xffffffffu) / 0x1p31));
}

static void TakePoint(FuzzBytes* bytes, const Space* space, double point[3])
{
    for (int axis = 0; axis < 3; axis++)
        point[axis] = TakeCoordinate(bytes, space);
}

/// One of the corners before, or a combination of three with weights that are multiples of a quarter.
static void TakeRelated(FuzzBytes* bytes, Space* space, const double (*corners)[3], int count, double point[3])
{
    static const double weights[][3] = {{1, 0, 0},  {0.5, 0.5, 0},    {0.5, 0.25, 0.25}, {0.25, 0.75, 0},
                                        {2, -1, 0}, {1, 1, -1},       {0.25, 0.25, 0.5}, {1.5, -0.25, -0.25},
                                        {-1, 1, 1}, {0.75, 0.75, -.5}};
    const double* w = weights[Fuzz_TakeBelow(bytes, 10)];
    int which[3];
    for (int i = 0; i < 3; i++)
        which[i] = (int)Fuzz_TakeBelow(bytes, (uint32_t)count);
    for (int axis = 0; axis < 3; axis++)
    {
        point[axis] = 0.0;
        for (int i = 0; i < 3; i++)
            point[axis] += w[i] * corners[which[i]][axis];
        space->isLattice = space->isLattice && point[axis] == floor(point[axis]) && fabs(point[axis]) < 0x1p36;
    }
}

static void MoveByUlps(FuzzBytes* bytes, Space* space, double point[3])
{
    int axis = (int)Fuzz_TakeBelow(bytes, 3);
    point[axis] = nextafter(point[axis], Fuzz_TakeBelow(bytes, 2) == 0 ? -INFINITY : INFINITY);
    space->isLattice = false;
}

/// `count` corners precede it.
static void TakeCorner(FuzzBytes* bytes, Space* space, const double (*corners)[3], int count, double point[3])
{
    switch (Fuzz_TakeBelow(bytes, 8))
    {
        default: TakePoint(bytes, space, point); break;
        case 4:
        case 5:
        case 6:
        case 7:
            if (count == 0)
                TakePoint(bytes, space, point);
            else
                TakeRelated(bytes, space, corners, count, point);
    }
    if (Fuzz_TakeBelow(bytes, 16) == 15)
        MoveByUlps(bytes, space, point);
}

static void Scale(const Space* space, double (*corners)[3], int count)
{
    for (int i = 0; i < 3 * count; i++)
    {
        double x = ldexp(corners[i / 3][i % 3], space->exponents[i % 3]);
        corners[i / 3][i % 3] = isfinite(x) ? x : copysign(DBL_MAX, x);
    }
}

static qcTrianglePair TakePair(FuzzBytes* bytes)
{
    Space space = TakeSpace(bytes);
    double corners[qc_cornerCount][3];
    for (int i = 0; i < qc_cornerCount; i++)
        TakeCorner(bytes, &space, (const double(*)[3])corners, i, corners[i]);
    Scale(&space, corners, qc_cornerCount);
    qcTrianglePair pair = {.kind = qc_pairKindCount};
    memcpy(pair.a, corners, sizeof pair.a);
    memcpy(pair.b, corners + 3, sizeof pair.b);
    return pair;
}

//  ---- at rest -----------------------------------------------------------------------------------------------------

static void CheckRelation(const qcTrianglePair* pair)
{
    qcRelation expected = qcOracle_Relate(pair->a, pair->b);
    FUZZ_CHECK(qcExact_Relate(pair->a, pair->b, NULL) == expected);
    FUZZ_CHECK(qcExact_Relate(pair->b, pair->a, NULL) == expected);
}

static void CheckOrientation(const qcTrianglePair* pair)
{
    const double *a = pair->a[0], *b = pair->a[1], *c = pair->a[2], *d = pair->b[0];
    int sign = qcOracle_Orient3d(a, b, c, d);
    FUZZ_CHECK(qcOrient3d(a, b, c, d, NULL) == sign);
    qcScaled value = qcOrient3dValue(a, b, c, d);
    FUZZ_CHECK((value.mantissa > 0) - (value.mantissa < 0) == sign);
    for (int axis = 0; axis < 3; axis++)
        FUZZ_CHECK(qcOrient2d(a, b, c, axis, (axis + 1) % 3, NULL) == qcOracle_Orient2d(a, b, c, axis, (axis + 1) % 3));
}

/// At the distance, next to it, and at a margin of the input's.
static void CheckWithin(FuzzBytes* bytes, const qcTrianglePair* pair)
{
    qcOracleDistance* exact = qcOracleDistance_Create(pair->a, pair->b);
    double distance = qcOracleDistance_Get(exact);
    const double margins[] = {distance, nextafter(distance, INFINITY), nextafter(distance, 0.0),
                              ldexp(Fuzz_TakeByte(bytes), (int)Fuzz_TakeByte(bytes) - 128)};
    qcRelation relation = qcExact_Relate(pair->a, pair->b, NULL);
    FUZZ_CHECK((relation == qc_relationDisjoint) == (qcOracleDistance_Compare(exact, 0.0) > 0));
    for (int i = 0; i < 4; i++)
    {
        if (!isfinite(margins[i]))
            continue;
        bool within = qcOracleDistance_Compare(exact, margins[i]) <= 0;
        qcRelation expected = relation != qc_relationDisjoint ? relation
                              : within                        ? qc_relationNear
                                                              : qc_relationDisjoint;
        FUZZ_CHECK(qcExact_Within(pair->a, pair->b, margins[i], NULL) == expected);
        FUZZ_CHECK(qcTrianglesWithin(&pair->b[0][0], &pair->a[0][0], margins[i], NULL) == within);
    }
    qcOracleDistance_Destroy(exact);
}

static void CheckSegment(const qcTrianglePair* pair)
{
    qcOracleAnswer exact;
    qcOracle_Intersect(pair->a, pair->b, &exact);
    if (exact.relation == qc_relationPenetrating)
        qcClaim_Segment(pair, &exact);
}

static void CheckProximity(const qcTrianglePair* pair)
{
    // Beyond, the distance may overflow.
    if (qcTrianglePair_GetExtent(pair) <= DBL_MAX / 4)
        qcClaim_Proximity(pair);
}

//  ---- in motion ---------------------------------------------------------------------------------------------------

/// Both ends; the first `common` corners of A and B are the same. Positions at times k / 64 are exact if the space is a
/// lattice.
static Pair TakeMotion(FuzzBytes* bytes, Space* space, int common)
{
    Pair pair = {.common = common};
    double vector[2][3];
    TakePoint(bytes, space, vector[0]);
    TakePoint(bytes, space, vector[1]);
    for (int i = 0; i < qc_cornerCount; i++)
    {
        double *start = pair.at[0][i], *end = pair.at[1][i];
        TakeCorner(bytes, space, (const double(*)[3])pair.at[0], i, start);
        uint32_t way = Fuzz_TakeBelow(bytes, 4);
        if (way == 0)
            TakeCorner(bytes, space, (const double(*)[3])pair.at[1], i, end);
        for (int axis = 0; axis < 3 && way != 0; axis++)
            end[axis] = start[axis] + (way == 1 ? 0.0 : vector[way - 2][axis]);
    }
    for (int t = 0; t < 2; t++)
        memcpy(pair.at[t] + 3, pair.at[t], (size_t)common * sizeof pair.at[t][0]);
    return pair;
}

static void Split(const Pair* pair, qcMovingTriangle* a, qcMovingTriangle* b)
{
    memcpy(a->start, pair->at[0], sizeof a->start);
    memcpy(a->end, pair->at[1], sizeof a->end);
    memcpy(b->start, pair->at[0] + 3, sizeof b->start);
    memcpy(b->end, pair->at[1] + 3, sizeof b->end);
}

/// Nothing meets at the ends, nor, on a lattice, at times between. `lattice` is not scaled.
static void CheckApart(const Space* space, const Pair* lattice, const Pair* pair)
{
    for (int t = 0; t < 2; t++)
        FUZZ_CHECK(!qcClaim_MeetElsewhere(pair->at[t], pair->common));
    for (int k = 0; k <= qc_times && space->isLattice; k += 4)
    {
        double corners[qc_cornerCount][3];
        qcClaim_GetPositions(lattice, k, corners);
        FUZZ_CHECK(!qcClaim_MeetElsewhere((const double(*)[3])corners, pair->common));
    }
}

static void CheckMotion(FuzzBytes* bytes, Claim claim)
{
    Space space = TakeSpace(bytes);
    int common = claim == qc_claimNeighbours ? 1 + (int)Fuzz_TakeBelow(bytes, 2) : 0;
    Pair lattice = TakeMotion(bytes, &space, common), pair = lattice;
    for (int t = 0; t < 2; t++)
        Scale(&space, pair.at[t], qc_cornerCount);
    qcMovingTriangle a, b;
    Split(&pair, &a, &b);
    // Subnormal and huge coordinates were rounded.
    for (int axis = 0; axis < 3; axis++)
        space.isLattice = space.isLattice && space.exponents[axis] >= -1074 && space.exponents[axis] < 950;
    if (claim == qc_claimNeighbours)
    {
        const uint32_t indicesA[3] = {0, 1, 2}, indicesB[3] = {0, common == 2 ? 1 : 4, 5};
        if (qcMotion_SeparatesNeighbours(&a, indicesA, &b, indicesB))
            CheckApart(&space, &lattice, &pair);
        return;
    }
    double direction[3];
    bool apart = qcMotion_Separates(&a, &b, direction);
    FUZZ_CHECK(apart == qcTrianglesStayApart(a.start[0], a.end[0], b.start[0], b.end[0], NULL));
    for (int t = 0; t < 2 && apart; t++)
        FUZZ_CHECK(qcClaim_IsAbove(direction, pair.at[t]));
    if (claim == qc_claimParts)
    {
        bool inParts = qcMotion_StaysApart(&a, &b);
        FUZZ_CHECK(inParts || !apart);
        if (inParts)
            CheckApart(&space, &lattice, &pair);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    FuzzBytes bytes = {data, size};
    Claim claim = (Claim)Fuzz_TakeBelow(&bytes, qc_claimCount);
    if (claim >= qc_claimMotion)
    {
        CheckMotion(&bytes, claim);
        return 0;
    }
    qcTrianglePair pair = TakePair(&bytes);
    switch (claim)
    {
        case qc_claimRelation: CheckRelation(&pair); break;
        case qc_claimOrientation: CheckOrientation(&pair); break;
        case qc_claimWithin: CheckWithin(&bytes, &pair); break;
        case qc_claimSegment: CheckSegment(&pair); break;
        default: CheckProximity(&pair);
    }
    return 0;
}
