// Seeded pairs of triangles on the border between two relations, built exactly from small integers: local coordinates
// (s, t, h), multiples of 12, in a random integer frame; h = 0 is the plane of the first triangle.
#include "support/pairs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum
{
    // Means of corners with weights in twelfths are integers.
    qc_unit = 12
};

static void SetAnywhere(qcRandom* random, double p[3])
{
    for (int axis = 0; axis < 3; ++axis)
        p[axis] = qc_unit * qcRandom_Integer(random, -2, 2);
}

static void SetInPlane(qcRandom* random, double p[3])
{
    SetAnywhere(random, p);
    p[2] = 0;
}

static void SetAlong(double p[3], const double from[3], const double direction[3], double steps)
{
    for (int axis = 0; axis < 3; ++axis)
        p[axis] = from[axis] + steps * direction[axis];
}

// A point inside (no zero weights), on an edge (one) or at a corner (two) of a triangle.
static void SetOnTriangle(qcRandom* random, double p[3], const double corners[3][3], uint32_t zeroWeights)
{
    double weights[3] = {0, 0, qc_unit};
    if (zeroWeights == 1)
    {
        weights[1] = qcRandom_Integer(random, 1, qc_unit - 1);
        weights[2] = qc_unit - weights[1];
    }
    else if (zeroWeights == 0)
    {
        weights[0] = qcRandom_Integer(random, 1, qc_unit - 2);
        weights[1] = qcRandom_Integer(random, 1, qc_unit - 1 - (int)weights[0]);
        weights[2] = qc_unit - weights[0] - weights[1];
    }
    uint32_t shift = qcRandom_Below(random, 3);
    for (int axis = 0; axis < 3; ++axis)
    {
        p[axis] = 0;
        for (uint32_t i = 0; i < 3; ++i)
            p[axis] += weights[(i + shift) % 3] * corners[i][axis] / qc_unit;
    }
}

static void SetUniform(qcRandom* random, double corners[3][3], bool single)
{
    for (int i = 0; i < 9; ++i)
    {
        double value = qcRandom_Uniform(random, -1, 1);
        corners[i / 3][i % 3] = single ? (double)(float)value : value;
    }
}

static void SetMixedExponents(qcRandom* random, double corners[3][3], int lower, int upper)
{
    for (int i = 0; i < 9; ++i)
    {
        int exponent = (int)qcRandom_Integer(random, lower, upper);
        corners[i / 3][i % 3] = ldexp(qcRandom_Uniform(random, -2, 2), exponent);
    }
}

static void SetCoarse(qcRandom* random, double corners[3][3])
{
    for (int i = 0; i < 9; ++i)
        corners[i / 3][i % 3] = qcRandom_Integer(random, 0, 2);
}

// Edges 0-1 of both pass through one point.
static void SetCrossingEdges(qcRandom* random, qcTrianglePair* pair)
{
    double point[3], d[3], e[3];
    SetInPlane(random, point);
    SetAnywhere(random, d);
    SetAnywhere(random, e);
    SetAlong(pair->a[0], point, d, qcRandom_Integer(random, 1, 3));
    SetAlong(pair->a[1], point, d, qcRandom_Integer(random, -3, -1));
    SetAlong(pair->b[0], point, e, qcRandom_Integer(random, 1, 3));
    SetAlong(pair->b[1], point, e, qcRandom_Integer(random, -3, -1));
}

// Edges 0-1 of both lie on one line.
static void SetCollinearEdges(qcRandom* random, qcTrianglePair* pair)
{
    double d[3];
    SetInPlane(random, d);
    SetAlong(pair->a[1], pair->a[0], d, qcRandom_Integer(random, 1, 3));
    SetAlong(pair->b[0], pair->a[0], d, qcRandom_Integer(random, -2, 3));
    SetAlong(pair->b[1], pair->a[0], d, qcRandom_Integer(random, -2, 4));
}

static void SetEdgeThrough(qcRandom* random, qcTrianglePair* pair)
{
    double point[3], d[3];
    SetOnTriangle(random, point, pair->a, qcRandom_Below(random, 3));
    SetAnywhere(random, d);
    SetAlong(pair->b[0], point, d, qcRandom_Integer(random, 1, 3));
    SetAlong(pair->b[1], point, d, qcRandom_Integer(random, -3, -1));
}

static void SetSmallAround(qcRandom* random, qcTrianglePair* pair)
{
    double point[3], direction[3];
    SetOnTriangle(random, point, pair->a, qcRandom_Below(random, 3));
    double size = ldexp(1, (int)qcRandom_Integer(random, -40, -10));
    for (int i = 0; i < 3; ++i)
    {
        SetAnywhere(random, direction);
        SetAlong(pair->b[i], point, direction, size);
    }
}

static void SetSliver(qcRandom* random, qcTrianglePair* pair)
{
    double direction[3];
    SetAlong(direction, pair->a[1], pair->a[0], -1);
    SetAlong(pair->a[2], pair->a[0], direction, 0.25 * qcRandom_Integer(random, -1, 5));
    SetEdgeThrough(random, pair);
    SetAnywhere(random, direction);
    SetAlong(pair->a[2], pair->a[2], direction, ldexp(1, (int)qcRandom_Integer(random, -40, -10)));
}

static void Collapse(qcRandom* random, double corners[3][3])
{
    double direction[3];
    switch (qcRandom_Below(random, 4))
    {
        case 0: memcpy(corners[2], corners[1], sizeof corners[2]); break;
        case 1:
            memcpy(corners[1], corners[0], sizeof corners[1]);
            memcpy(corners[2], corners[0], sizeof corners[2]);
            break;
        default:
            SetAlong(direction, corners[1], corners[0], -1);
            SetAlong(corners[2], corners[0], direction, qcRandom_Integer(random, -2, 3));
            break;
    }
}

// In local coordinates. `pair->a` lies in the plane, `pair->b` anywhere, except for what the kind sets.
static void SetLattice(qcRandom* random, qcPairKind kind, qcTrianglePair* pair)
{
    for (int i = 0; i < 3; ++i)
    {
        SetInPlane(random, pair->a[i]);
        if (kind == qc_pairCoplanar || qcRandom_Below(random, 8) == 0)
            SetInPlane(random, pair->b[i]);
        else
            SetAnywhere(random, pair->b[i]);
    }
    switch (kind)
    {
        case qc_pairVertexOnFace: SetOnTriangle(random, pair->b[0], pair->a, 0); break;
        case qc_pairVertexOnEdge: SetOnTriangle(random, pair->b[0], pair->a, 1); break;
        case qc_pairVertexOnVertex: SetOnTriangle(random, pair->b[0], pair->a, 2); break;
        case qc_pairEdgeThroughFace: SetEdgeThrough(random, pair); break;
        case qc_pairEdgeThroughEdge: SetCrossingEdges(random, pair); break;
        case qc_pairCollinearEdges: SetCollinearEdges(random, pair); break;
        case qc_pairSharedEdge: memcpy(pair->b, pair->a, 2 * sizeof pair->a[0]); break;
        case qc_pairEdgeInFace:
            SetOnTriangle(random, pair->b[0], pair->a, qcRandom_Below(random, 3));
            SetOnTriangle(random, pair->b[1], pair->a, qcRandom_Below(random, 3));
            break;
        case qc_pairContained:
            for (int i = 0; i < 3; ++i)
                SetOnTriangle(random, pair->b[i], pair->a, qcRandom_Below(random, 3));
            break;
        case qc_pairIdentical: memcpy(pair->b, pair->a, sizeof pair->a); break;
        case qc_pairSmallOnLarge: SetSmallAround(random, pair); break;
        case qc_pairSliver: SetSliver(random, pair); break;
        default: break;
    }
}

// Random axes; in half of all calls a permutation of the world's.
static void SetFrame(qcRandom* random, double frame[3][3])
{
    if (qcRandom_Below(random, 2) == 0)
    {
        uint32_t shift = qcRandom_Below(random, 3);
        for (uint32_t i = 0; i < 9; ++i)
            frame[i / 3][i % 3] = (i / 3 + shift) % 3 == i % 3;
        return;
    }
    double determinant = 0;
    while (determinant == 0)
    {
        for (int i = 0; i < 9; ++i)
            frame[i / 3][i % 3] = qcRandom_Integer(random, -4, 4);
        determinant = 0;
        for (int i = 0; i < 3; ++i)
        {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            determinant += frame[0][i] * (frame[1][j] * frame[2][k] - frame[1][k] * frame[2][j]);
        }
    }
}

static void ApplyFrame(const double frame[3][3], double corners[3][3])
{
    for (int i = 0; i < 3; ++i)
    {
        double p[3];
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = corners[i][0] * frame[0][axis] + corners[i][1] * frame[1][axis] + corners[i][2] * frame[2][axis];
        memcpy(corners[i], p, sizeof p);
    }
}

static void Shuffle(qcRandom* random, double corners[3][3])
{
    for (uint32_t i = 2; i > 0; --i)
    {
        uint32_t j = qcRandom_Below(random, i + 1);
        double moved[3];
        memcpy(moved, corners[i], sizeof moved);
        memmove(corners[i], corners[j], sizeof moved);
        memcpy(corners[j], moved, sizeof moved);
    }
}

void qcTrianglePair_Make(qcRandom* random, qcPairKind kind, qcTrianglePair* pair)
{
    double frame[3][3];
    qcPairKind base = kind == qc_pairDegenerate ? (qcPairKind)qcRandom_Below(random, qc_pairDegenerate) : kind;
    pair->kind = kind;
    switch (base)
    {
        case qc_pairGeneral:
        case qc_pairFloat:
            SetUniform(random, pair->a, base == qc_pairFloat);
            SetUniform(random, pair->b, base == qc_pairFloat);
            break;
        case qc_pairMixedExponents:
        {
            // 1018: a segment three times as long is still finite.
            int range = (const int[]){4, 30, 100, 1018}[qcRandom_Below(random, 4)];
            SetMixedExponents(random, pair->a, range == 1018 ? -1074 : -range, range);
            SetMixedExponents(random, pair->b, range == 1018 ? -1074 : -range, range);
            break;
        }
        case qc_pairCoarseGrid:
            SetCoarse(random, pair->a);
            SetCoarse(random, pair->b);
            break;
        default: SetLattice(random, base, pair); break;
    }
    if (kind == qc_pairDegenerate)
    {
        Shuffle(random, pair->a);
        uint32_t which = qcRandom_Below(random, 4);
        if (which != 0)
            Collapse(random, pair->a);
        if (which < 2)
            Collapse(random, pair->b);
    }
    if (base > qc_pairCoarseGrid)
    {
        SetFrame(random, frame);
        ApplyFrame(frame, pair->a);
        ApplyFrame(frame, pair->b);
    }
    Shuffle(random, pair->a);
    Shuffle(random, pair->b);
    if (qcRandom_Below(random, 2) == 0)
    {
        qcTrianglePair original = *pair;
        memcpy(pair->a, original.b, sizeof pair->a);
        memcpy(pair->b, original.a, sizeof pair->b);
    }
}

double qcTrianglePair_GetLargest(const qcTrianglePair* pair)
{
    double largest = 0;
    for (int i = 0; i < 9; ++i)
        largest = fmax(largest, fmax(fabs(pair->a[i / 3][i % 3]), fabs(pair->b[i / 3][i % 3])));
    return largest;
}

static void Scale(qcTrianglePair* pair, double factor, int exponent)
{
    for (int i = 0; i < 9; ++i)
    {
        pair->a[i / 3][i % 3] = ldexp(factor * pair->a[i / 3][i % 3], exponent);
        pair->b[i / 3][i % 3] = ldexp(factor * pair->b[i / 3][i % 3], exponent);
    }
}

static void Move(qcRandom* random, qcTrianglePair* pair, bool integer)
{
    for (int axis = 0; axis < 3; ++axis)
    {
        double offset = qcRandom_Uniform(random, -1e7, 1e7);
        offset = integer ? floor(offset) : offset;
        for (int i = 0; i < 3; ++i)
        {
            pair->a[i][axis] += offset;
            pair->b[i][axis] += offset;
        }
    }
}

static void ScaleToExtreme(qcRandom* random, qcTrianglePair* pair, double largest)
{
    if (largest == 0)
        return;
    // The last binade, sizes whose products overflow or underflow, and denormals of 4 to 40 bits.
    int magnitude =
        (const int[]){1023, 1000, -990, (int)qcRandom_Integer(random, -1070, -1034)}[qcRandom_Below(random, 4)];
    Scale(pair, 1, magnitude - ilogb(largest));
}

void qcTrianglePair_MoveByUlps(qcRandom* random, qcTrianglePair* pair)
{
    double largest = qcTrianglePair_GetLargest(pair);
    double ulp = largest - nextafter(largest, 0);
    bool relative = qcRandom_Below(random, 2) == 0;
    for (uint32_t count = 1 + qcRandom_Below(random, 3); count > 0; --count)
    {
        uint32_t which = qcRandom_Below(random, 18);
        double* value = which < 9 ? &pair->a[which / 3][which % 3] : &pair->b[which / 3 - 3][which % 3];
        double steps = qcRandom_Integer(random, -3, 3);
        double moved = *value + (relative ? steps * ulp : 0);
        for (double i = 0; i < fabs(steps) && !relative; ++i)
            moved = nextafter(moved, steps < 0 ? -INFINITY : INFINITY);
        if (isfinite(moved))
            *value = moved;
    }
}

void qcTrianglePair_Disturb(qcRandom* random, qcTrianglePair* pair)
{
    // Mixed exponents must not be scaled up.
    if (qcTrianglePair_GetLargest(pair) < 1e40)
    {
        uint32_t scale = qcRandom_Below(random, 8);
        if (scale < 4)
            Scale(pair, scale < 2 ? qcRandom_Uniform(random, 1, 2) : 1, (int)qcRandom_Integer(random, -20, 20));
        uint32_t offset = qcRandom_Below(random, 4);
        if (offset < 2)
            Move(random, pair, offset == 0);
        if (qcRandom_Below(random, 8) == 0)
            ScaleToExtreme(random, pair, qcTrianglePair_GetLargest(pair));
    }
    if (qcRandom_Below(random, 2) == 0)
        qcTrianglePair_MoveByUlps(random, pair);
}

void qcTrianglePair_MakeAny(qcRandom* random, qcTrianglePair* pair)
{
    qcTrianglePair_Make(random, (qcPairKind)qcRandom_Below(random, qc_pairKindCount), pair);
    qcTrianglePair_Disturb(random, pair);
}

//  ---- at a known distance ------------------------------------------------------------------------------------------

// Corners 0 .. count - 1 lie in the plane h = 0 with the origin in their hull, the others in it or on one side of it.
static void SetAround(qcRandom* random, double corners[3][3], int count, int side)
{
    for (int i = 0; i < 3; ++i)
    {
        corners[i][0] = qcRandom_Integer(random, -6, 6);
        corners[i][1] = qcRandom_Integer(random, -6, 6);
        corners[i][2] = i < count ? 0 : side * qcRandom_Integer(random, 0, 6);
    }
    double first = qcRandom_Integer(random, 0, 3), second = qcRandom_Integer(random, 0, 3);
    for (int axis = 0; axis < 2; ++axis)
    {
        if (count == 1)
            corners[0][axis] = 0;
        if (count == 2)
            corners[1][axis] = -first * corners[0][axis];
        if (count == 3)
            corners[2][axis] = -first * corners[0][axis] - second * corners[1][axis];
    }
}

// Three perpendicular integer axes of the same integer length, which is returned: a rotation by an integer quaternion.
static double SetRotation(qcRandom* random, double frame[3][3])
{
    double q[4], length = 0;
    while (length == 0)
    {
        length = 0;
        for (int i = 0; i < 4; ++i)
        {
            q[i] = qcRandom_Below(random, 3) == 0 ? 0 : qcRandom_Integer(random, -3, 3);
            length += q[i] * q[i];
        }
    }
    for (int i = 0; i < 3; ++i)
    {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        frame[i][i] = q[3] * q[3] + q[i] * q[i] - q[j] * q[j] - q[k] * q[k];
        frame[i][j] = 2 * (q[i] * q[j] - q[3] * q[k]);
        frame[i][k] = 2 * (q[i] * q[k] + q[3] * q[j]);
    }
    return length;
}

void qcTrianglePair_MakeApart(qcRandom* random, int cornersA, int cornersB, qcTrianglePair* pair, double* distance)
{
    double frame[3][3];
    pair->kind = qc_pairKindCount;
    *distance = qcRandom_Integer(random, 1, 12);
    SetAround(random, pair->a, cornersA, -1);
    SetAround(random, pair->b, cornersB, 1);
    for (int i = 0; i < 3; ++i)
        pair->b[i][2] += *distance;
    *distance *= SetRotation(random, frame);
    ApplyFrame((const double(*)[3])frame, pair->a);
    ApplyFrame((const double(*)[3])frame, pair->b);
    Shuffle(random, pair->a);
    Shuffle(random, pair->b);
    if (qcRandom_Below(random, 2) == 0)
        Move(random, pair, true);
    int exponent = (int)qcRandom_Integer(random, -20, 20);
    if (qcRandom_Below(random, 10) == 0)
        exponent = (const int[]){990, 500, -500, -1022, -1074}[qcRandom_Below(random, 5)];
    Scale(pair, 1, exponent);
    *distance = ldexp(*distance, exponent);
}

char* qcTrianglePair_Print(const qcTrianglePair* pair, char text[1024])
{
    int length = sprintf(text, "kind %d:", (int)pair->kind);
    for (int i = 0; i < 18; ++i)
    {
        double value = i < 9 ? pair->a[i / 3][i % 3] : pair->b[i / 3 - 3][i % 3];
        const char* separator = i == 0 ? " a =" : i == 9 ? "; b =" : ",";
        length += sprintf(text + length, "%s %a", separator, value);
    }
    return text;
}

int qcGetTestPairCount(int minCount)
{
    const char* text = getenv("QC_TEST_PAIRS");
    int count = text != NULL ? atoi(text) : 0;
    return count > minCount ? count : minCount;
}
