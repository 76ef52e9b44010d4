// Finds whether a triangle is degenerate: a segment or a point.
#include "triangle/exact.h"

static const double* Lower(const double* a, const double* b, int axis)
{
    return b[axis] < a[axis] ? b : a;
}

static const double* Higher(const double* a, const double* b, int axis)
{
    return b[axis] > a[axis] ? b : a;
}

qcSimplex qcSimplex_Of(const double triangle[3][3], uint64_t* undecided)
{
    const double *a = triangle[0], *b = triangle[1], *c = triangle[2];
    qcSimplex s = {2, {a, b, c}, 0, 0, 0};
    for (int axis = 0; axis < 3; axis++)
    {
        s.u = (axis + 1) % 3;
        s.v = (axis + 2) % 3;
        s.sign = qcOrient2d(a, b, c, s.u, s.v, undecided);
        if (s.sign != 0)
            return s;
    }
    // Flat in all three projections: the corners are collinear. A coordinate in which they differ orders them.
    for (int axis = 0; axis < 3; axis++)
    {
        const double* low = Lower(Lower(a, b, axis), c, axis);
        const double* high = Higher(Higher(a, b, axis), c, axis);
        if (low[axis] < high[axis])
            return (qcSimplex){1, {low, high, high}, axis, axis, 0};
    }
    return (qcSimplex){0, {a, a, a}, 0, 0, 0};
}
