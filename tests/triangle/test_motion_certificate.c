// Certificates of motion against exact arithmetic: their directions in integers (GMP), and the triangles themselves at
// times k / 64. Corners lie on lattices of at most 46 bits, so that positions at these times are exact in double.
#include "support/oracle.h"
#include "support/oracle_integers.h"
#include "support/pairs.h"
#include "support/suite.h"
#include "triangle/motion_certificate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum
{
    qc_times = 64,
    qc_sampleStep = 4, ///< every fourth time, from a random one on; and half time and both ends
    qc_cornerCount = 6
};

/// Corners 0 to 2 are those of A.
typedef struct Pair
{
    double at[2][qc_cornerCount][3]; ///< at the start and at the end
    int common;                      ///< the first corners of A and of B that are one vertex
} Pair;

typedef struct Class Class;
struct Class
{
    const char* name;
    void (*make)(qcRandom* random, const Class* c, Pair* pair);
    int bits;          ///< the size of a triangle is 2^bits
    double maxMotion;  ///< in sizes
    double offset;     ///< max distance from the origin, in sizes
    int exponents[2];  ///< the pair is scaled by one of these powers of two
    int common;        ///< corners that both triangles have
    bool isOffLattice; ///< only the ends are related exactly
    double minShare;   ///< of the pairs that are not seen to meet, so many are certified
};

//  ---- generators --------------------------------------------------------------------------------------------------

static double Round(double x)
{
    return floor(x + 0.5);
}

static void RandomVector(qcRandom* random, double size, double v[3])
{
    for (int axis = 0; axis < 3; axis++)
        v[axis] = Round(qcRandom_Uniform(random, -size, size));
}

static void AddVector(const double v[3], double p[3])
{
    for (int axis = 0; axis < 3; axis++)
        p[axis] += v[axis];
}

/// Translates one of the triangles (0, 1), or both (2), at one end.
static void Translate(Pair* pair, int t, int which, const double v[3])
{
    for (int c = which == 1 ? 3 : 0; c < (which == 0 ? 3 : qc_cornerCount); c++)
        AddVector(v, pair->at[t][c]);
}

/// From 0.01 sizes to the class's max motion, each magnitude as often.
static double MotionOf(qcRandom* random, const Class* c)
{
    return ldexp(0.01, c->bits) * exp(qcRandom_Uniform(random, 0.0, log(100.0 * c->maxMotion)));
}

/// Common vertices have one position.
static void Unite(Pair* pair)
{
    for (int t = 0; t < 2; t++)
        memcpy(pair->at[t][3], pair->at[t][0], sizeof pair->at[t][0] * (size_t)pair->common);
}

static void Jitter(qcRandom* random, double size, Pair* pair)
{
    for (int c = 0; c < qc_cornerCount; c++)
    {
        double v[3];
        RandomVector(random, size, v);
        AddVector(v, pair->at[1][c]);
    }
}

/// Turns one of the triangles, or both, about a point at the end. Corners are rounded to the lattice.
static void Turn(qcRandom* random, Pair* pair, int which, const double about[3])
{
    double axis[3] = {qcRandom_Uniform(random, -1, 1), qcRandom_Uniform(random, -1, 1),
                      qcRandom_Uniform(random, -1, 1)};
    double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    double angle = qcRandom_Uniform(random, -3, 3), cosine = cos(angle), sine = sin(angle);
    for (int k = 0; k < 3; k++)
        axis[k] /= length;
    for (int c = which == 1 ? 3 : 0; c < (which == 0 ? 3 : qc_cornerCount); c++)
    {
        double *p = pair->at[1][c], arm[3] = {p[0] - about[0], p[1] - about[1], p[2] - about[2]};
        double along = axis[0] * arm[0] + axis[1] * arm[1] + axis[2] * arm[2];
        for (int k = 0; k < 3; k++)
        {
            double across = axis[(k + 1) % 3] * arm[(k + 2) % 3] - axis[(k + 2) % 3] * arm[(k + 1) % 3];
            p[k] = Round(about[k] + cosine * arm[k] + (1.0 - cosine) * along * axis[k] + sine * across);
        }
    }
}

/// Both anywhere at the start, at up to three sizes from each other.
static void PlaceAnywhere(qcRandom* random, const Class* c, Pair* pair)
{
    double size = ldexp(1.0, c->bits), v[3];
    for (int i = 0; i < qc_cornerCount; i++)
        RandomVector(random, size, pair->at[0][i]);
    RandomVector(random, qcRandom_Uniform(random, 0.0, 3.0) * size, v);
    Translate(pair, 0, 1, v);
}

/// The end from the start: free flight, one past the other, a turn of both, or a motion of each corner.
static void MoveAnyhow(qcRandom* random, const Class* c, Pair* pair)
{
    double motion = MotionOf(random, c), size = ldexp(1.0, c->bits), v[3];
    memcpy(pair->at[1], pair->at[0], sizeof pair->at[1]);
    RandomVector(random, motion, v);
    switch (qcRandom_Below(random, 4))
    {
        case 0:
            Translate(pair, 1, 2, v);
            Jitter(random, fmin(motion, 0.1 * size), pair);
            break;
        case 1: Translate(pair, 1, 1, v); break;
        case 2:
            Turn(random, pair, 2, pair->at[0][0]);
            Translate(pair, 1, 2, v);
            break;
        default: Jitter(random, motion, pair);
    }
}

static void MakeRandom(qcRandom* random, const Class* c, Pair* pair)
{
    PlaceAnywhere(random, c, pair);
    MoveAnyhow(random, c, pair);
}

static void MakeTurning(qcRandom* random, const Class* c, Pair* pair)
{
    PlaceAnywhere(random, c, pair);
    memcpy(pair->at[1], pair->at[0], sizeof pair->at[1]);
    Turn(random, pair, 0, pair->at[0][qcRandom_Below(random, qc_cornerCount)]);
    Turn(random, pair, 1, pair->at[0][qcRandom_Below(random, qc_cornerCount)]);
}

/// Few lattice points: many corners on faces, edges and corners at both ends.
static void MakeCoarse(qcRandom* random, const Class* c, Pair* pair)
{
    for (int t = 0; t < 2; t++)
        for (int i = 0; i < qc_cornerCount; i++)
            RandomVector(random, 2.0, pair->at[t][i]);
    if (qcRandom_Below(random, 2) == 0)
        memcpy(pair->at[1], pair->at[0], sizeof pair->at[1]);
    double v[3];
    RandomVector(random, c->maxMotion, v);
    Translate(pair, 1, 1, v);
    RandomVector(random, 2.0, v);
    Translate(pair, 0, 1, v);
}

/// All corners in one plane, which moves.
static void MakeCoplanar(qcRandom* random, const Class* c, Pair* pair)
{
    double frame[2][3];
    MakeRandom(random, c, pair);
    RandomVector(random, 4.0, frame[0]);
    RandomVector(random, 4.0, frame[1]);
    for (int t = 0; t < 2; t++)
        for (int i = 0; i < qc_cornerCount; i++)
        {
            double* p = pair->at[t][i];
            double u = p[0], v = p[1];
            for (int axis = 0; axis < 3; axis++)
                p[axis] = u * frame[0][axis] + v * frame[1][axis];
        }
    double v[3];
    RandomVector(random, MotionOf(random, c), v);
    Translate(pair, 1, 2, v);
}

/// Needles: the third corner of each is a few lattice units from the line of the other two.
static void MakeNeedles(qcRandom* random, const Class* c, Pair* pair)
{
    MakeRandom(random, c, pair);
    for (int t = 0; t < 2; t++)
        for (int i = 0; i < qc_cornerCount; i += 3)
        {
            double at = qcRandom_Uniform(random, -1.0, 2.0), v[3];
            for (int axis = 0; axis < 3; axis++)
                pair->at[t][i + 2][axis] =
                    Round(pair->at[t][i][axis] + at * (pair->at[t][i + 1][axis] - pair->at[t][i][axis]));
            RandomVector(random, 2.0, v);
            AddVector(v, pair->at[t][i + 2]);
        }
}

/// True if a corner is on the lower side of the plane of A through corner 3, up to rounding.
static bool IsBelow(const double at[qc_cornerCount][3], int corner)
{
    double height = 0.0;
    for (int axis = 0; axis < 3; axis++)
    {
        int j = (axis + 1) % 3, k = (axis + 2) % 3;
        double normal = (at[1][j] - at[0][j]) * (at[2][k] - at[0][k]) - (at[1][k] - at[0][k]) * (at[2][j] - at[0][j]);
        height += normal * (at[corner][axis] - at[3][axis]);
    }
    return height < 0.0;
}

/// Moves B at one end so that a corner of it, or a point of an edge, lies on A, up to a few lattice units.
static void MakeTouch(qcRandom* random, double maxGap, double at[qc_cornerCount][3])
{
    double move[3], weights[3] = {qcRandom_Integer(random, 0, 8), qcRandom_Integer(random, 0, 4), 0.0};
    double along = qcRandom_Below(random, 4) != 0 ? 0.0 : qcRandom_Integer(random, 1, 15);
    weights[2] = 16.0 - weights[0] - weights[1];
    RandomVector(random, maxGap, move);
    for (int axis = 0; axis < 3; axis++)
    {
        // With coordinates that are multiples of sixteen, these points are on the lattice.
        for (int i = 0; i < qc_cornerCount; i++)
            at[i][axis] = 16.0 * Round(at[i][axis] / 16.0);
        for (int i = 0; i < 3; i++)
            move[axis] += weights[i] * at[i][axis] / 16.0;
        move[axis] -= ((16.0 - along) * at[3][axis] + along * at[4][axis]) / 16.0;
    }
    for (int i = 3; i < qc_cornerCount; i++)
        AddVector(move, at[i]);
    // The corner that touches is the lowest one: otherwise nearly all pairs would penetrate.
    for (int i = 4; i < qc_cornerCount && along == 0.0; i++)
        for (int axis = 0, below = IsBelow((const double(*)[3])at, i); axis < 3 && below; axis++)
            at[i][axis] = 2.0 * at[3][axis] - at[i][axis];
}

static void MakeTouchingEnd(qcRandom* random, const Class* c, Pair* pair)
{
    MakeRandom(random, c, pair);
    MakeTouch(random, 1.0, pair->at[1]);
}

static void MakeTouchingStart(qcRandom* random, const Class* c, Pair* pair)
{
    MakeRandom(random, c, pair);
    MakeTouch(random, 1.0, pair->at[0]);
}

/// Apart, or not, by a few lattice units at both ends.
static void MakeTinyGaps(qcRandom* random, const Class* c, Pair* pair)
{
    double v[3];
    PlaceAnywhere(random, c, pair);
    MakeTouch(random, 3.0, pair->at[0]);
    memcpy(pair->at[1], pair->at[0], sizeof pair->at[1]);
    RandomVector(random, MotionOf(random, c), v);
    Translate(pair, 1, 2, v);
    Jitter(random, 1.0, pair);
}

/// On different sides of a plane that turns with A; at the end B may be on the other side.
static void MakePassing(qcRandom* random, const Class* c, Pair* pair)
{
    double size = ldexp(1.0, c->bits), v[3];
    PlaceAnywhere(random, c, pair);
    for (int i = 0; i < qc_cornerCount; i++)
    {
        double height = Round(qcRandom_Uniform(random, 0.0, 0.2 * size));
        pair->at[0][i][2] = i < 3 ? -height : height + 1.0;
    }
    memcpy(pair->at[1], pair->at[0], sizeof pair->at[1]);
    v[0] = v[1] = 0.0;
    v[2] = Round(MotionOf(random, c));
    Translate(pair, 1, 0, v);
    RandomVector(random, MotionOf(random, c), v);
    Translate(pair, 1, 2, v);
}

/// Two layers of a cloth in flight: close, nearly parallel, in a motion much longer than their distance.
static void MakeLayers(qcRandom* random, const Class* c, Pair* pair)
{
    double size = ldexp(1.0, c->bits), gap = Round(size * qcRandom_Uniform(random, 0.01, 0.2)), v[3];
    PlaceAnywhere(random, c, pair);
    for (int i = 0; i < qc_cornerCount; i++)
        pair->at[0][i][2] = (i < 3 ? 0.0 : gap) + Round(qcRandom_Uniform(random, -0.3, 0.3) * gap);
    memcpy(pair->at[1], pair->at[0], sizeof pair->at[1]);
    Jitter(random, 0.7 * gap, pair);
    RandomVector(random, MotionOf(random, c), v);
    Translate(pair, 1, 2, v);
}

/// Both ends are equally far from a position, in opposite directions: it is taken on at half time.
static void MoveThrough(qcRandom* random, double motion, Pair* pair)
{
    for (int i = 0; i < qc_cornerCount; i++)
    {
        double v[3], back[3];
        RandomVector(random, motion, v);
        for (int axis = 0; axis < 3; axis++)
            back[axis] = -v[axis];
        memcpy(pair->at[1][i], pair->at[0][i], sizeof v);
        AddVector(v, pair->at[1][i]);
        AddVector(back, pair->at[0][i]);
    }
}

/// Triangles that touch at half time.
static void MakeTouchingMidway(qcRandom* random, const Class* c, Pair* pair)
{
    PlaceAnywhere(random, c, pair);
    MakeTouch(random, 0.0, pair->at[0]);
    MoveThrough(random, MotionOf(random, c), pair);
}

/// Neighbours that lie in one plane at half time, folded upon each other or not.
static void MakeFolding(qcRandom* random, const Class* c, Pair* pair)
{
    double normal[3];
    PlaceAnywhere(random, c, pair);
    RandomVector(random, 4.0, normal);
    for (int i = 0; i < qc_cornerCount; i++)
        pair->at[0][i][2] = normal[0] * pair->at[0][i][0] + normal[1] * pair->at[0][i][1];
    MoveThrough(random, MotionOf(random, c), pair);
}

/// Neighbours on a smooth surface: around a vertex, or on both sides of an edge.
static void MakeSmooth(qcRandom* random, const Class* c, Pair* pair)
{
    double size = ldexp(1.0, c->bits), angles[qc_cornerCount] = {0.0}, v[3];
    for (int i = 1; i < qc_cornerCount; i++)
        angles[i] = angles[i - 1] + qcRandom_Uniform(random, 0.5, 1.0);
    if (pair->common == 2)
        angles[5] = angles[1] - qcRandom_Uniform(random, 0.5, 1.0);
    for (int i = 0; i < qc_cornerCount; i++)
    {
        double radius = i % 3 == 0 ? 0.0 : size * qcRandom_Uniform(random, 0.6, 1.0);
        pair->at[0][i][0] = Round(radius * cos(angles[i]));
        pair->at[0][i][1] = Round(radius * sin(angles[i]));
        pair->at[0][i][2] = i % 3 == 0 ? 0.0 : Round(size * qcRandom_Uniform(random, -0.1, 0.1));
    }
    memcpy(pair->at[1], pair->at[0], sizeof pair->at[1]);
    Jitter(random, fmin(0.2 * size, MotionOf(random, c)), pair);
    RandomVector(random, MotionOf(random, c), v);
    Translate(pair, 1, 2, v);
}

/// Any doubles, moved by ulps or by a common vector, or two pairs that have nothing to do with each other.
static void MakeAny(qcRandom* random, const Class* c, Pair* pair)
{
    (void)c;
    qcTrianglePair made;
    uint32_t kind = qcRandom_Below(random, 4);
    for (int t = 0; t < 2; t++)
    {
        if (t == 0 || kind == 0)
            qcTrianglePair_MakeAny(random, &made);
        else
            qcTrianglePair_MoveByUlps(random, &made);
        memcpy(pair->at[t], made.a, sizeof made.a);
        memcpy(pair->at[t] + 3, made.b, sizeof made.b);
    }
    double size = qcTrianglePair_GetLargest(&made);
    for (int axis = 0; axis < 3 && kind == 2; axis++)
    {
        double by = size * qcRandom_Uniform(random, -3.0, 3.0);
        for (int i = 0; i < qc_cornerCount; i++)
            if (isfinite(pair->at[1][i][axis] + by))
                pair->at[1][i][axis] += by;
    }
}

static void MakePair(qcRandom* random, const Class* c, Pair* pair)
{
    pair->common = c->common;
    c->make(random, c, pair);
    Unite(pair);
    double offset[3];
    RandomVector(random, ldexp(c->offset, c->bits), offset);
    int exponent = c->exponents[qcRandom_Below(random, 2)];
    for (int t = 0; t < 2; t++)
        for (int i = 0; i < qc_cornerCount; i++)
            for (int axis = 0; axis < 3 && !c->isOffLattice; axis++)
                pair->at[t][i][axis] = ldexp(pair->at[t][i][axis] + offset[axis], exponent);
}

//  ---- what is claimed ---------------------------------------------------------------------------------------------

/// Integers that are used again for each pair.
typedef struct Integers
{
    mpz_t corner[qc_cornerCount][3], direction[3], product, lowest, highest;
} Integers;

static void InitIntegers(Integers* x)
{
    mpz_inits(x->product, x->lowest, x->highest, NULL);
    for (int axis = 0; axis < 3; axis++)
    {
        mpz_init(x->direction[axis]);
        for (int i = 0; i < qc_cornerCount; i++)
            mpz_init(x->corner[i][axis]);
    }
}

static void ClearIntegers(Integers* x)
{
    mpz_clears(x->product, x->lowest, x->highest, NULL);
    for (int axis = 0; axis < 3; axis++)
    {
        mpz_clear(x->direction[axis]);
        for (int i = 0; i < qc_cornerCount; i++)
            mpz_clear(x->corner[i][axis]);
    }
}

/// All corners of A are above all corners of B along the direction.
static bool IsAbove(Integers* x, const double direction[3], const double corners[qc_cornerCount][3])
{
    mpz_t* integers[3 * qc_cornerCount];
    const double* values[3 * qc_cornerCount];
    for (int axis = 0; axis < 3; axis++)
    {
        integers[axis] = &x->direction[axis];
        values[axis] = &direction[axis];
    }
    (void)qcOracle_ToIntegers(integers, values, 3);
    for (int i = 0; i < 3 * qc_cornerCount; i++)
    {
        integers[i] = &x->corner[i / 3][i % 3];
        values[i] = &corners[i / 3][i % 3];
    }
    (void)qcOracle_ToIntegers(integers, values, 3 * qc_cornerCount);
    for (int i = 0; i < qc_cornerCount; i++)
    {
        mpz_mul(x->product, x->direction[0], x->corner[i][0]);
        mpz_addmul(x->product, x->direction[1], x->corner[i][1]);
        mpz_addmul(x->product, x->direction[2], x->corner[i][2]);
        mpz_t* bound = i < 3 ? &x->lowest : &x->highest;
        if (i % 3 == 0 || (i < 3 ? mpz_cmp(x->product, *bound) < 0 : mpz_cmp(x->product, *bound) > 0))
            mpz_set(*bound, x->product);
    }
    return mpz_cmp(x->lowest, x->highest) > 0;
}

/// Whether the hulls of some corners have a common point.
static bool Meet(const double corners[qc_cornerCount][3], const int a[3], const int b[3])
{
    double p[3][3], q[3][3];
    for (int i = 0; i < 3; i++)
    {
        memcpy(p[i], corners[a[i]], sizeof p[i]);
        memcpy(q[i], corners[b[i]], sizeof q[i]);
    }
    return qcRelateTriangles(p[0], q[0]) != qc_relationDisjoint;
}

/// True if the triangles have a common point that is not one of their common vertices or of their common edge. For
/// neighbours: see the_test_for_neighbours_is_that_of_the_oracle.
static bool MeetElsewhere(const double corners[qc_cornerCount][3], int common)
{
    static const int a[3] = {0, 1, 2}, b[3] = {3, 4, 5}, edgeOfA[3] = {1, 2, 2}, edgeOfB[3] = {4, 5, 5},
                     cornerOfA[3] = {2, 2, 2}, cornerOfB[3] = {5, 5, 5}, firstA[3] = {0, 2, 2}, firstB[3] = {3, 5, 5};
    if (common == 0)
        return Meet(corners, a, b);
    if (common == 1)
        return Meet(corners, edgeOfA, b) || Meet(corners, edgeOfB, a);
    return Meet(corners, cornerOfA, b) || Meet(corners, cornerOfB, a) || Meet(corners, firstA, edgeOfB) ||
           Meet(corners, edgeOfA, firstB);
}

/// At time k / 64, times 64: exact.
static void GetPositions(const Pair* pair, int k, double corners[qc_cornerCount][3])
{
    for (int i = 0; i < qc_cornerCount; i++)
        for (int axis = 0; axis < 3; axis++)
            corners[i][axis] = (qc_times - k) * pair->at[0][i][axis] + k * pair->at[1][i][axis];
}

static bool MeetAtSampledTime(qcRandom* random, const Class* c, const Pair* pair)
{
    for (int t = 0; t < 2; t++)
        if (MeetElsewhere(pair->at[t], pair->common))
            return true;
    int first = 1 + (int)qcRandom_Below(random, qc_sampleStep);
    for (int k = first - qc_sampleStep; k < qc_times && !c->isOffLattice; k += qc_sampleStep)
    {
        double corners[qc_cornerCount][3];
        GetPositions(pair, k < 0 ? qc_times / 2 : k, corners);
        if (MeetElsewhere(corners, pair->common))
            return true;
    }
    return false;
}

static void Fail(const Class* c, const Pair* pair, const char* what)
{
    for (int t = 0; t < 2; t++)
        for (int i = 0; i < qc_cornerCount; i++)
            printf("%s %c%d: %a, %a, %a\n", t == 0 ? "start" : "end", "ab"[i / 3], i % 3, pair->at[t][i][0],
                   pair->at[t][i][1], pair->at[t][i][2]);
    ck_abort_msg("%s: %s", c->name, what);
}

/// A triangle of the pair, with its corners in another order, and their vertex indices.
static void GetTriangle(const Pair* pair, int first, uint32_t order, qcMovingTriangle* triangle, uint32_t indices[3])
{
    for (uint32_t c = 0; c < 3; c++)
    {
        // The first three orders keep the orientation, the others reverse it.
        int corner = (int)(order < 3 ? (c + order) % 3 : (order - c) % 3);
        memcpy(triangle->start[c], pair->at[0][first + corner], sizeof triangle->start[c]);
        memcpy(triangle->end[c], pair->at[1][first + corner], sizeof triangle->end[c]);
        indices[c] = (uint32_t)(corner < pair->common ? corner : first + corner);
    }
}

/// In any order of the corners and of the triangles.
static bool Certify(qcRandom* random, Integers* integers, const Class* c, const Pair* pair)
{
    qcMovingTriangle a, b;
    uint32_t indicesA[3], indicesB[3];
    GetTriangle(pair, 0, qcRandom_Below(random, 6), &a, indicesA);
    GetTriangle(pair, 3, qcRandom_Below(random, 6), &b, indicesB);
    bool isReversed = qcRandom_Below(random, 2) == 0;
    bool apart = isReversed ? qcMotion_SeparatesNeighbours(&b, indicesB, &a, indicesA)
                            : qcMotion_SeparatesNeighbours(&a, indicesA, &b, indicesB);
    if (pair->common != 0)
        return apart;
    double direction[3];
    bool found = isReversed ? qcMotion_Separates(&b, &a, direction) : qcMotion_Separates(&a, &b, direction);
    if (found != apart)
        Fail(c, pair, "the result depends on whether a direction is required");
    for (int axis = 0; axis < 3 && isReversed; axis++)
        direction[axis] = -direction[axis];
    for (int t = 0; t < 2 && apart; t++)
        if (!IsAbove(integers, direction, pair->at[t]))
            Fail(c, pair,
                 t == 0 ? "the direction doesn't separate the start" : "the direction doesn't separate the end");
    return apart;
}

//  ---- tests -------------------------------------------------------------------------------------------------------

static const Class s_classes[] = {
    {"random, float", MakeRandom, 16, 100.0, 0.0, {0, -10}, 0, false, 0.85},
    {"random, double", MakeRandom, 38, 100.0, 0.0, {0, -38}, 0, false, 0.85},
    {"turning", MakeTurning, 20, 1.0, 0.0, {0, -20}, 0, false, 0.83},
    {"coarse lattice", MakeCoarse, 1, 4.0, 0.0, {0, -1}, 0, false, 0.8},
    {"coplanar", MakeCoplanar, 16, 100.0, 0.0, {0, -16}, 0, false, 0.9},
    {"needles", MakeNeedles, 30, 10.0, 0.0, {0, -30}, 0, false, 0.9},
    {"touching at the end", MakeTouchingEnd, 38, 10.0, 0.0, {0, -38}, 0, false, 0.5},
    {"touching at the start", MakeTouchingStart, 20, 10.0, 0.0, {0, -20}, 0, false, 0.5},
    {"tiny gaps", MakeTinyGaps, 40, 1.0, 0.0, {0, -40}, 0, false, 0.9},
    {"tiny gaps, float", MakeTinyGaps, 20, 1.0, 0.0, {0, -20}, 0, false, 0.95},
    {"passing", MakePassing, 16, 100.0, 0.0, {0, -16}, 0, false, 0.8},
    {"layers in flight", MakeLayers, 16, 100.0, 0.0, {0, -16}, 0, false, 0.99},
    {"far away, float", MakeRandom, 4, 4.0, 1e6, {0, -4}, 0, false, 0.88},
    {"far away, double", MakeLayers, 22, 100.0, 1e6, {0, -22}, 0, false, 0.99},
    {"1e-20 and 1e20", MakeRandom, 20, 100.0, 0.0, {-86, 46}, 0, false, 0.85},
    {"1e-306 and 1e300", MakeLayers, 16, 100.0, 0.0, {-1036, 980}, 0, false, 0.99},
    {"touching midway", MakeTouchingMidway, 30, 10.0, 0.0, {0, -30}, 0, false, 0.0},
    {"any doubles", MakeAny, 0, 1.0, 0.0, {0, 0}, 0, true, 0.65},
    {"common vertex", MakeRandom, 16, 100.0, 0.0, {0, -16}, 1, false, 0.8},
    {"common edge", MakeRandom, 16, 100.0, 0.0, {0, -16}, 2, false, 0.7},
    {"common vertex, coarse", MakeCoarse, 1, 2.0, 0.0, {0, -1}, 1, false, 0.7},
    {"common edge, coarse", MakeCoarse, 1, 2.0, 0.0, {0, -1}, 2, false, 0.5},
    {"common vertex, folding", MakeFolding, 20, 10.0, 0.0, {0, -20}, 1, false, 0.75},
    {"common edge, folding", MakeFolding, 20, 10.0, 0.0, {0, -20}, 2, false, 0.55},
    {"common vertex, smooth", MakeSmooth, 22, 100.0, 0.0, {0, -22}, 1, false, 0.99},
    {"common edge, smooth", MakeSmooth, 22, 100.0, 0.0, {0, -22}, 2, false, 0.99},
    {"common vertex, far away", MakeSmooth, 22, 100.0, 1e6, {0, -80}, 1, false, 0.99},
};

enum
{
    qc_classCount = sizeof s_classes / sizeof s_classes[0],
    qc_firstNeighbours = 18
};

START_TEST(nothing_that_is_certified_meets)
{
    const Class* c = &s_classes[_i];
    qcRandom random = {1000 + (uint64_t)_i};
    Integers integers;
    InitIntegers(&integers);
    int count = qcGetTestPairCount(300000) / qc_classCount, certified = 0, met = 0;
    for (int i = 0; i < count; i++)
    {
        Pair pair;
        MakePair(&random, c, &pair);
        bool apart = Certify(&random, &integers, c, &pair), meets = MeetAtSampledTime(&random, c, &pair);
        if (apart && meets)
            Fail(c, &pair, "a certified pair meets");
        certified += apart;
        met += meets;
    }
    ClearIntegers(&integers);
    printf("%-24s %9d pairs %9d certified %9d met %9d neither\n", c->name, count, certified, met,
           count - certified - met);
    ck_assert_int_ge(certified, (int)(c->minShare * (count - met)));
}
END_TEST

/// The corners lie on one line.
static bool IsDegenerate(const double triangle[3][3])
{
    return qcOracle_Orient2d(triangle[0], triangle[1], triangle[2], 0, 1) == 0 &&
           qcOracle_Orient2d(triangle[0], triangle[1], triangle[2], 1, 2) == 0 &&
           qcOracle_Orient2d(triangle[0], triangle[1], triangle[2], 2, 0) == 0;
}

START_TEST(the_test_for_neighbours_is_that_of_the_oracle)
{
    qcRandom random = {2000};
    int count = qcGetTestPairCount(300000) / 10, met[3] = {0, 0, 0}, apart[3] = {0, 0, 0};
    for (int i = 0; i < count; i++)
    {
        const Class* c = &s_classes[qc_firstNeighbours + qcRandom_Below(&random, qc_classCount - qc_firstNeighbours)];
        Pair pair;
        MakePair(&random, c, &pair);
        double at[qc_cornerCount][3];
        GetPositions(&pair, (int)qcRandom_Below(&random, 3) * qc_times / 2, at);
        const double(*corners)[3] = (const double(*)[3])at;
        if (IsDegenerate(corners) || IsDegenerate(corners + 3))
            continue;
        // The corners of the intersection are those of the common vertex or edge, or there are more.
        qcOracleAnswer answer;
        qcOracle_Intersect(corners, corners + 3, &answer);
        bool meets = answer.pointCount != c->common;
        ck_assert_int_eq(meets, MeetElsewhere(corners, c->common));
        (meets ? met : apart)[c->common]++;
    }
    for (int common = 1; common <= 2; common++)
    {
        ck_assert_int_gt(met[common], count / 100);
        ck_assert_int_gt(apart[common], count / 100);
    }
}
END_TEST

int main(void)
{
    Suite* suite = suite_create("motion certificate");
    TCase* tests = tcase_create("certificates");
    tcase_set_timeout(tests, 0);
    tcase_add_loop_test(tests, nothing_that_is_certified_meets, 0, qc_classCount);
    tcase_add_test(tests, the_test_for_neighbours_is_that_of_the_oracle);
    suite_add_tcase(suite, tests);
    return qcRunSuite(suite);
}
