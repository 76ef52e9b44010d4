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

/// Sets `to` to the corners relative to `origin`. Returns the largest coordinate; NaN and infinity are kept.
static double MakeRelative(const double from[3][3], const double origin[3], double to[3][3])
{
    double size = 0.0;
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
        {
            to[c][k] = from[c][k] - origin[k];
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
        minA = fmin(minA, qcDot(qcVector_Load(v), qcVector_Load(a[c])));
        maxB = fmax(maxB, qcDot(qcVector_Load(v), qcVector_Load(b[c])));
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

bool qcMotion_StaysApart(const qcMovingTriangle* a, const qcMovingTriangle* b)
{
    if (qcMotion_Separates(a, b, NULL))
        return true;
    if (!AreDisjoint(a->end, b->end) || !AreDisjoint(a->start, b->start))
        return false;
    RelativePair pair;
    const double sizes[4] = {MakeRelative(a->start, a->start[0], pair.a.start),
                             MakeRelative(b->start, a->start[0], pair.b.start),
                             MakeRelative(a->end, a->end[0], pair.a.end), MakeRelative(b->end, a->end[0], pair.b.end)};
    double size = 0.0;
    for (int i = 0; i < 4; i++)
        size = sizes[i] <= size ? size : sizes[i];
    return size >= s_minSize && size <= s_maxSize && HalvesAreProven(&pair, size, qc_maxDepth);
}
