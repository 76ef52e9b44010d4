// Orientation predicates: a floating-point filter, then integers. Error bounds: Shewchuk, Adaptive Precision
// Floating-Point Arithmetic and Fast Robust Geometric Predicates, 1997, sections 4.2 and 4.3 (stage A).
// Proof: plugin/docs/proofs/orientation_filter.md.
#include "triangle/exact.h"

#include "triangle/determinant.h"

#include <float.h>
#include <math.h>

static const double s_bound3 = (7.0 + 56.0 * (DBL_EPSILON / 2)) * (DBL_EPSILON / 2);
static const double s_bound2 = (3.0 + 16.0 * (DBL_EPSILON / 2)) * (DBL_EPSILON / 2);
// Far above any underflow, and below any determinant of a scene with edges longer than 1e-90.
static const double s_underflow = 1e-290;

typedef struct Filtered
{
    double determinant, bound;
} Filtered;

/// What determinants of one plane have in common: two edges from its first point, and their minor.
typedef struct Plane
{
    const double* a;
    double bx, by, bz, cx, cy, cz;
    double minor, permanent;
} Plane;

static inline Plane PlaneOf(const double a[3], const double b[3], const double c[3])
{
    Plane p = {a, b[0] - a[0], b[1] - a[1], b[2] - a[2], c[0] - a[0], c[1] - a[1], c[2] - a[2], 0.0, 0.0};
    double bxcy = p.bx * p.cy, cxby = p.cx * p.by;
    p.minor = bxcy - cxby;
    p.permanent = fabs(bxcy) + fabs(cxby);
    return p;
}

static inline Filtered DeterminantOf(const Plane* p, const double d[3])
{
    double dx = d[0] - p->a[0], dy = d[1] - p->a[1], dz = d[2] - p->a[2];
    double cxdy = p->cx * dy, dxcy = dx * p->cy, dxby = dx * p->by, bxdy = p->bx * dy;
    double permanent =
        p->permanent * fabs(dz) + (fabs(cxdy) + fabs(dxcy)) * fabs(p->bz) + (fabs(dxby) + fabs(bxdy)) * fabs(p->cz);
    Filtered f;
    f.determinant = dz * p->minor + p->bz * (cxdy - dxcy) + p->cz * (dxby - bxdy);
    f.bound = s_bound3 * permanent + s_underflow * (1.0 + fabs(p->bz) + fabs(p->cz) + fabs(dz));
    return f;
}

static inline Filtered Determinant3(const double a[3], const double b[3], const double c[3], const double d[3])
{
    const Plane plane = PlaneOf(a, b, c);
    return DeterminantOf(&plane, d);
}

/// 0: the filter leaves it open. Without a branch, since either sign is as likely.
static inline int SignOf(Filtered f)
{
    return (f.determinant > f.bound) - (-f.determinant > f.bound);
}

static bool AreSame(const double a[3], const double b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/// Two of four points are one: their determinant is 0.
static bool HaveSame(const double a[3], const double b[3], const double c[3], const double d[3])
{
    return AreSame(a, b) || AreSame(a, c) || AreSame(a, d) || AreSame(b, c) || AreSame(b, d) || AreSame(c, d);
}

/// All four points have one coordinate in common: their determinant is 0.
static bool ShareCoordinate(const double a[3], const double b[3], const double c[3], const double d[3])
{
    for (int axis = 0; axis < 3; axis++)
        if (a[axis] == b[axis] && a[axis] == c[axis] && a[axis] == d[axis])
            return true;
    return false;
}

/// The sign of a determinant that the filter leaves open.
__attribute__((noinline)) static int Decide3(const double a[3], const double b[3], const double c[3], const double d[3],
                                             uint64_t* undecided)
{
    if (HaveSame(a, b, c, d) || ShareCoordinate(a, b, c, d))
        return 0;
    if (undecided != NULL)
        ++*undecided;
    double exact = qcExactDeterminant3(a, b, c, d).mantissa;
    return (exact > 0.0) - (exact < 0.0);
}

int qcOrient3d(const double a[3], const double b[3], const double c[3], const double d[3], uint64_t* undecided)
{
    Filtered f = Determinant3(a, b, c, d);
    int sign = SignOf(f);
    return sign != 0 ? sign : Decide3(a, b, c, d, undecided);
}

void qcOrient3dSides(const double t[3][3], const double points[3][3], int side[3], uint64_t* undecided)
{
    const Plane plane = PlaneOf(t[0], t[1], t[2]);
    for (int i = 0; i < 3; i++)
    {
        Filtered f = DeterminantOf(&plane, points[i]);
        side[i] = SignOf(f);
        if (side[i] == 0)
            side[i] = Decide3(t[0], t[1], t[2], points[i], undecided);
    }
}

qcScaled qcOrient3dValue(const double a[3], const double b[3], const double c[3], const double d[3])
{
    Filtered f = Determinant3(a, b, c, d);
    // 2^20 times the error bound: the value is right to 20 bits more than its sign.
    if (fabs(f.determinant) > 1048576.0 * f.bound && fabs(f.determinant) <= DBL_MAX)
    {
        qcScaled value;
        value.mantissa = frexp(f.determinant, &value.exponent);
        return value;
    }
    return qcExactDeterminant3(a, b, c, d);
}

int qcOrient2d(const double a[3], const double b[3], const double c[3], int u, int v, uint64_t* undecided)
{
    double left = (b[u] - a[u]) * (c[v] - a[v]);
    double right = (b[v] - a[v]) * (c[u] - a[u]);
    double determinant = left - right;
    double bound = s_bound2 * (fabs(left) + fabs(right)) + s_underflow;
    if (determinant > bound)
        return 1;
    if (-determinant > bound)
        return -1;
    // Both products are 0, since each has two equal coordinates.
    if ((b[u] == a[u] || c[v] == a[v]) && (b[v] == a[v] || c[u] == a[u]))
        return 0;
    if (undecided != NULL)
        ++*undecided;
    return qcExactSign2(a[u], a[v], b[u], b[v], c[u], c[v]);
}
