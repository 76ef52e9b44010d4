// Pairs of moving triangles in many classes, for the test of certificates. Corners lie on lattices of at most 46 bits,
// so that positions at times k / 64 are exact in double.
#ifndef QC_TESTS_TRIANGLE_MOVING_PAIRS_H
#define QC_TESTS_TRIANGLE_MOVING_PAIRS_H

#include "support/pairs.h"

#include <math.h>
#include <string.h>

enum
{
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

static inline double Round(double x)
{
    return floor(x + 0.5);
}

static inline void RandomVector(qcRandom* random, double size, double v[3])
{
    for (int axis = 0; axis < 3; axis++)
        v[axis] = Round(qcRandom_Uniform(random, -size, size));
}

static inline void AddVector(const double v[3], double p[3])
{
    for (int axis = 0; axis < 3; axis++)
        p[axis] += v[axis];
}

/// Translates one of the triangles (0, 1), or both (2), at one end.
static inline void Translate(Pair* pair, int t, int which, const double v[3])
{
    for (int c = which == 1 ? 3 : 0; c < (which == 0 ? 3 : qc_cornerCount); c++)
        AddVector(v, pair->at[t][c]);
}

/// From 0.01 sizes to the class's max motion, each magnitude as often.
static inline double MotionOf(qcRandom* random, const Class* c)
{
    return ldexp(0.01, c->bits) * exp(qcRandom_Uniform(random, 0.0, log(100.0 * c->maxMotion)));
}

/// Common vertices have one position.
static inline void Unite(Pair* pair)
{
    for (int t = 0; t < 2; t++)
        memcpy(pair->at[t][3], pair->at[t][0], sizeof pair->at[t][0] * (size_t)pair->common);
}

static inline void Jitter(qcRandom* random, double size, Pair* pair)
{
    for (int c = 0; c < qc_cornerCount; c++)
    {
        double v[3];
        RandomVector(random, size, v);
        AddVector(v, pair->at[1][c]);
    }
}

/// Turns one of the triangles, or both, about a point at the end. Corners are rounded to the lattice.
static inline void Turn(qcRandom* random, Pair* pair, int which, const double about[3])
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
static inline void PlaceAnywhere(qcRandom* random, const Class* c, Pair* pair)
{
    double size = ldexp(1.0, c->bits), v[3];
    for (int i = 0; i < qc_cornerCount; i++)
        RandomVector(random, size, pair->at[0][i]);
    RandomVector(random, qcRandom_Uniform(random, 0.0, 3.0) * size, v);
    Translate(pair, 0, 1, v);
}

/// The end from the start: free flight, one past the other, a turn of both, or a motion of each corner.
static inline void MoveAnyhow(qcRandom* random, const Class* c, Pair* pair)
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

static inline void MakeRandom(qcRandom* random, const Class* c, Pair* pair)
{
    PlaceAnywhere(random, c, pair);
    MoveAnyhow(random, c, pair);
}

static inline void MakeTurning(qcRandom* random, const Class* c, Pair* pair)
{
    PlaceAnywhere(random, c, pair);
    memcpy(pair->at[1], pair->at[0], sizeof pair->at[1]);
    Turn(random, pair, 0, pair->at[0][qcRandom_Below(random, qc_cornerCount)]);
    Turn(random, pair, 1, pair->at[0][qcRandom_Below(random, qc_cornerCount)]);
}

/// Few lattice points: many corners on faces, edges and corners at both ends.
static inline void MakeCoarse(qcRandom* random, const Class* c, Pair* pair)
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
static inline void MakeCoplanar(qcRandom* random, const Class* c, Pair* pair)
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
static inline void MakeNeedles(qcRandom* random, const Class* c, Pair* pair)
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
static inline bool IsBelow(const double at[qc_cornerCount][3], int corner)
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
static inline void MakeTouch(qcRandom* random, double maxGap, double at[qc_cornerCount][3])
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

static inline void MakeTouchingEnd(qcRandom* random, const Class* c, Pair* pair)
{
    MakeRandom(random, c, pair);
    MakeTouch(random, 1.0, pair->at[1]);
}

static inline void MakeTouchingStart(qcRandom* random, const Class* c, Pair* pair)
{
    MakeRandom(random, c, pair);
    MakeTouch(random, 1.0, pair->at[0]);
}

/// Apart, or not, by a few lattice units at both ends.
static inline void MakeTinyGaps(qcRandom* random, const Class* c, Pair* pair)
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
static inline void MakePassing(qcRandom* random, const Class* c, Pair* pair)
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
static inline void MakeLayers(qcRandom* random, const Class* c, Pair* pair)
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
static inline void MoveThrough(qcRandom* random, double motion, Pair* pair)
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
static inline void MakeTouchingMidway(qcRandom* random, const Class* c, Pair* pair)
{
    PlaceAnywhere(random, c, pair);
    MakeTouch(random, 0.0, pair->at[0]);
    MoveThrough(random, MotionOf(random, c), pair);
}

/// Neighbours that lie in one plane at half time, folded upon each other or not.
static inline void MakeFolding(qcRandom* random, const Class* c, Pair* pair)
{
    double normal[3];
    PlaceAnywhere(random, c, pair);
    RandomVector(random, 4.0, normal);
    for (int i = 0; i < qc_cornerCount; i++)
        pair->at[0][i][2] = normal[0] * pair->at[0][i][0] + normal[1] * pair->at[0][i][1];
    MoveThrough(random, MotionOf(random, c), pair);
}

/// Neighbours on a smooth surface: around a vertex, or on both sides of an edge.
static inline void MakeSmooth(qcRandom* random, const Class* c, Pair* pair)
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
static inline void MakeAny(qcRandom* random, const Class* c, Pair* pair)
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

static inline void MakePair(qcRandom* random, const Class* c, Pair* pair)
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

#endif
