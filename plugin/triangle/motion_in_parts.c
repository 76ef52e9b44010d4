// A motion is halved in time until one direction separates the triangles at both ends of each part. Positions are
// relative to a moving origin, so that rounding depends on the size of the pair only. Proof:
// plugin/docs/proofs/motion_in_parts.md.
#include "triangle/motion_in_parts.h"

#include "base/vec3.h"
#include "triangle/exact.h"

#include <math.h>

enum
{
    qc_maxDepth = 4 ///< halvings: a turn by 160 degrees becomes 16 of 10
};

// Beyond these sizes products of relative positions and directions could overflow, or lose digits.
static const double s_minSize = 1e-100, s_maxSize = 1e100;

/// Two triangles relative to the first corner of `a`, which is the origin at all times.
typedef struct RelativePair
{
    qcMovingTriangle a, b;
} RelativePair;

/// Sets `to` to the corners relative to the first one of a triangle. Returns the largest coordinate; NaN and infinity
/// are kept.
static double MakeRelative(const double from[3][3], const double triangle[3][3], double to[3][3])
{
    double size = 0.0;
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
        {
            to[c][k] = from[c][k] - triangle[0][k];
            size = fabs(to[c][k]) <= size ? size : fabs(to[c][k]);
        }
    return size;
}

/// True if `v` separates the triangles at one end by more than `tolerance`.
static bool SeparatesBy(const double a[3][3], const double b[3][3], const double v[3], double tolerance)
{
    double minA = INFINITY, maxB = -INFINITY;
    for (int c = 0; c < 3; c++)
    {
        const double onA = qcDot(qcVector_Load(v), qcVector_Load(a[c]));
        const double onB = qcDot(qcVector_Load(v), qcVector_Load(b[c]));
        minA = onA < minA ? onA : minA;
        maxB = onB > maxB ? onB : maxB;
    }
    return minA - maxB > tolerance;
}

/// True if a direction is found that separates the exact corners, which are those of `pair` up to rounding. `size`: the
/// largest coordinate of the whole motion.
static bool IsProven(const RelativePair* pair, double size)
{
    double v[3];
    if (!qcMotion_Separates(&pair->a, &pair->b, v))
        return false;
    double tolerance = 0x1p-47 * size * (fabs(v[0]) + fabs(v[1]) + fabs(v[2]));
    return SeparatesBy(pair->a.start, pair->b.start, v, tolerance) &&
           SeparatesBy(pair->a.end, pair->b.end, v, tolerance);
}

static void Halve(const qcMovingTriangle* whole, qcMovingTriangle* first, qcMovingTriangle* second)
{
    *first = *second = *whole;
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
            first->end[c][k] = second->start[c][k] = 0.5 * whole->start[c][k] + 0.5 * whole->end[c][k];
}

/// Most pairs that aren't proven meet at an end or halfway, which is tested faster than certificates fail.
static bool AreDisjoint(const double a[3][3], const double b[3][3])
{
    return qcExact_Relate(a, b, NULL) == qc_relationDisjoint;
}

static bool HalvesAreProven(const RelativePair* pair, double size, int depth)
{
    RelativePair halves[2];
    Halve(&pair->a, &halves[0].a, &halves[1].a);
    Halve(&pair->b, &halves[0].b, &halves[1].b);
    if (!AreDisjoint(halves[1].a.start, halves[1].b.start))
        return false;
    // Pairs that meet do so towards the end, mostly.
    for (int i = 1; i >= 0; i--)
        if (!IsProven(&halves[i], size) && (depth == 1 || !HalvesAreProven(&halves[i], size, depth - 1)))
            return false;
    return true;
}

//  ---- pairs that meet -----------------------------------------------------------------------------------------------
//
// What is computed here is not exact, and need not be: a pair that seems to meet is given up.

/// A part of the motion; empty if the first time is after the last.
typedef struct Times
{
    double first, last;
} Times;

/// A corner relative to the first corner of a triangle, at one end.
static qcVector FromFirst(const double corner[3], const double triangle[3][3])
{
    return qcMinus(qcVector_Load(corner), qcVector_Load(triangle[0]));
}

/// The times at which the plane of `triangle`, as if it did not turn, has corners of the other one on both sides.
static Times FindCrossing(const qcMovingTriangle* triangle, const qcMovingTriangle* other)
{
    qcVector edges[2];
    for (int i = 0; i < 2; i++)
        edges[i] = qcPlusScaled(FromFirst(triangle->start[i + 1], triangle->start),
                                FromFirst(triangle->end[i + 1], triangle->end), 1.0);
    const qcVector normal = qcCross(edges[0], edges[1]);
    Times times = {1.0, 0.0};
    int aboveAtStart = 0, aboveAtEnd = 0;
    for (int c = 0; c < 3; c++)
    {
        const double start = qcDot(normal, FromFirst(other->start[c], triangle->start));
        const double end = qcDot(normal, FromFirst(other->end[c], triangle->end));
        aboveAtStart += start > 0.0;
        aboveAtEnd += end > 0.0;
        if ((start > 0.0) == (end > 0.0))
            continue;
        const double time = start / (start - end);
        times.first = time < times.first ? time : times.first;
        times.last = time > times.last ? time : times.last;
    }
    return (Times){aboveAtStart % 3 != 0 ? 0.0 : times.first, aboveAtEnd % 3 != 0 ? 1.0 : times.last};
}

/// The times at which each triangle crosses the plane of the other.
static Times FindCommonCrossing(const RelativePair* pair)
{
    const Times ofA = FindCrossing(&pair->b, &pair->a), ofB = FindCrossing(&pair->a, &pair->b);
    return (Times){ofA.first > ofB.first ? ofA.first : ofB.first, ofA.last < ofB.last ? ofA.last : ofB.last};
}

static void PlaceAt(const qcMovingTriangle* triangle, double time, double corners[3][3])
{
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
            corners[c][k] = (1.0 - time) * triangle->start[c][k] + time * triangle->end[c][k];
}

/// True if the triangles meet at a time.
static bool MeetAt(const RelativePair* pair, double time)
{
    double corners[2][3][3];
    PlaceAt(&pair->a, time, corners[0]);
    PlaceAt(&pair->b, time, corners[1]);
    return !AreDisjoint(corners[0], corners[1]);
}

/// True if the triangles meet at one of these parts of a time.
static bool MeetWithin(const RelativePair* pair, Times times, const double* parts, int count)
{
    for (int i = 0; i < count && times.first <= times.last; i++)
        if (MeetAt(pair, times.first + parts[i] * (times.last - times.first)))
            return true;
    return false;
}

bool qcMotion_StaysApart(const qcMovingTriangle* a, const qcMovingTriangle* b)
{
    // Three of four pairs that meet do so at one of the first times; the others cost less than a failure in parts.
    static const double soon[] = {0.5, 0.25, 0.75}, late[] = {0.125, 0.875, 0.375, 0.625};
    if (qcMotion_BoxesSeparate(a, b, NULL))
        return true;
    RelativePair pair;
    const double sizes[4] = {MakeRelative(a->start, a->start, pair.a.start),
                             MakeRelative(b->start, a->start, pair.b.start), MakeRelative(a->end, a->end, pair.a.end),
                             MakeRelative(b->end, a->end, pair.b.end)};
    double size = 0.0;
    for (int i = 0; i < 4; i++)
        size = sizes[i] <= size ? size : sizes[i];
    if (!(size >= s_minSize && size <= s_maxSize))
        return qcMotion_FindDirection(a, b, NULL);
    const Times crossing = FindCommonCrossing(&pair);
    if (MeetWithin(&pair, crossing, soon, 3))
        return false;
    if (qcMotion_FindDirection(a, b, NULL))
        return true;
    return AreDisjoint(a->end, b->end) && AreDisjoint(a->start, b->start) && !MeetWithin(&pair, crossing, late, 4) &&
           HalvesAreProven(&pair, size, qc_maxDepth);
}
