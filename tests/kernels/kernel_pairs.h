// Pairs of triangles in single precision, side by side, for the kernels that compare them.
#ifndef QC_TESTS_KERNELS_KERNEL_PAIRS_H
#define QC_TESTS_KERNELS_KERNEL_PAIRS_H

#include "support/pairs.h"
#include "sweep/sample_bodies.h"

#include <math.h>

enum
{
    qc_maxBatch = 48
};

/// Triangles of both sides: pair i consists of triangle i of each.
typedef struct qcBatch
{
    qcPoint points[2][3 * qc_maxBatch];
    qcCorners corners[qc_maxBatch];
    size_t count;
} qcBatch;

/// The last pair is the one under test; the others are those of previous tests.
static inline void qcBatch_Push(qcBatch* batch, double a[3][3], double b[3][3])
{
    if (batch->count == qc_maxBatch)
        batch->count = 0;
    size_t at = batch->count++;
    for (uint32_t c = 0; c < 3; c++)
    {
        qcPoint *p = &batch->points[0][3 * at + c], *q = &batch->points[1][3 * at + c];
        for (int axis = 0; axis < 3; axis++)
        {
            p->x[axis] = (float)a[c][axis];
            q->x[axis] = (float)b[c][axis];
        }
        p->x[3] = q->x[3] = 0.0f;
        batch->corners[at].vertex[c] = (uint32_t)(3 * at) + c;
    }
}

static inline qcIndexedTriangles qcBatch_Side(const qcBatch* batch, int side)
{
    return (qcIndexedTriangles){batch->corners, batch->points[side]};
}

static inline float qcRoundUp(double value)
{
    return nextafterf((float)value, INFINITY);
}

static inline float qcRoundDown(double value)
{
    return value > 0.0 ? nextafterf((float)value, 0.0f) : 0.0f;
}

/// From a pair's own coordinates to the unit box, by a power of two. The error of points is at most 2^-24.
typedef struct qcUnitFrame
{
    double unit, origin[3];
} qcUnitFrame;

/// False: too large or too small for doubles.
static inline bool qcUnitFrame_Find(qcUnitFrame* frame, const qcTrianglePair* pair, double margin)
{
    double widest = margin;
    for (int axis = 0; axis < 3; axis++)
    {
        double low = pair->a[0][axis], high = low;
        for (int c = 0; c < 3; c++)
        {
            low = fmin(low, fmin(pair->a[c][axis], pair->b[c][axis]));
            high = fmax(high, fmax(pair->a[c][axis], pair->b[c][axis]));
        }
        frame->origin[axis] = low;
        widest = fmax(widest, high - low);
    }
    if (widest > 1e280 || widest < 1e-280)
        return false;
    int exponent;
    frexp(widest, &exponent);
    frame->unit = ldexp(1.0, -exponent);
    return true;
}

static inline void qcUnitFrame_Transform(const qcUnitFrame* frame, const double corners[3][3], double inUnitBox[3][3])
{
    for (int c = 0; c < 3; c++)
        for (int axis = 0; axis < 3; axis++)
            inUnitBox[c][axis] = (corners[c][axis] - frame->origin[axis]) * frame->unit;
}

static inline void qcUnitFrame_Push(const qcUnitFrame* frame, const qcTrianglePair* pair, qcBatch* batch)
{
    double a[3][3], b[3][3];
    qcUnitFrame_Transform(frame, pair->a, a);
    qcUnitFrame_Transform(frame, pair->b, b);
    qcBatch_Push(batch, a, b);
}

static inline void qcCross(const double a[3], const double b[3], double c[3])
{
    for (int i = 0; i < 3; i++)
        c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static inline double qcDot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Two triangles at distance `distance` along n: a vertex over a face, or two edges that cross. The rest of both leans
/// away from the plane between them, at least slightly.
static inline void qcMakeOverEachOther(qcRandom* random, bool edges, double distance, double a[3][3], double b[3][3],
                                       double n[3])
{
    double u[3], v[3], foot[3];
    for (int i = 0; i < 3; i++)
    {
        u[i] = qcRandom_Uniform(random, -0.4, 0.4);
        v[i] = qcRandom_Uniform(random, -0.4, 0.4);
        foot[i] = qcRandom_Uniform(random, 0.4, 0.6);
    }
    if (qcRandom_Below(random, 2) == 0)
        u[2] = v[2] = 0.0; // n along an axis: as long as the sum of its coordinates
    qcCross(u, v, n);
    double length = sqrt(qcDot(n, n));
    for (int i = 0; i < 3; i++)
        n[i] /= length;
    for (int c = 0; c < 3; c++)
    {
        double s = qcRandom_Uniform(random, -0.3, 0.3), t = qcRandom_Uniform(random, -0.3, 0.3),
               lean = qcRandom_Uniform(random, 0.0, 0.01);
        for (int i = 0; i < 3; i++)
        {
            // A lies in the plane through the foot, or has its edge along u; B has its corner above, or its edge along
            // v.
            a[c][i] = foot[i] + (c == 0 ? -u[i] - v[i] : c == 1 ? u[i] - 0.5 * v[i] : v[i]) * 0.5;
            b[c][i] = foot[i] + n[i] * distance;
            if (edges)
            {
                a[c][i] = foot[i] + (c == 0 ? -0.5 * u[i] : c == 1 ? 0.5 * u[i] : s * u[i] + t * v[i] - lean * n[i]);
                b[c][i] += c == 0 ? -0.5 * v[i] : c == 1 ? 0.5 * v[i] : s * v[i] - t * u[i] + lean * n[i];
            }
            else if (c != 0)
                b[c][i] += s * u[i] + t * v[i] + lean * n[i];
        }
    }
}

/// Moves both along n in opposite directions: closer to each other if `by` is negative.
static inline void qcMoveApart(double a[3][3], double b[3][3], const double n[3], double by)
{
    for (int axis = 0; axis < 3; axis++)
    {
        double move = n[axis] > 0.0 ? by : n[axis] < 0.0 ? -by : 0.0;
        for (int c = 0; c < 3; c++)
        {
            a[c][axis] -= move;
            b[c][axis] += move;
        }
    }
}

/// A random transform from the second side's frame to the first: rotated, scaled and moved. `back`: the corners `b` in
/// the second frame.
static inline void qcMakeTransform(qcRandom* random, qcDistanceThresholds* thresholds, double b[3][3],
                                   double back[3][3])
{
    // The rotation of a quaternion that isn't normalized.
    double scale = exp2(qcRandom_Uniform(random, -6.0, 6.0));
    double q[4] = {qcRandom_Uniform(random, -1, 1), qcRandom_Uniform(random, -1, 1), qcRandom_Uniform(random, -1, 1),
                   qcRandom_Uniform(random, 0.5, 1)};
    double length = qcDot(q, q) + q[3] * q[3];
    thresholds->isTransformed = true;
    for (int r = 0; r < 3; r++)
    {
        int s = (r + 1) % 3, t = (r + 2) % 3;
        thresholds->linear[r][r] = (float)((q[3] * q[3] + q[r] * q[r] - q[s] * q[s] - q[t] * q[t]) / length * scale);
        thresholds->linear[r][s] = (float)(2.0 * (q[r] * q[s] - q[t] * q[3]) / length * scale);
        thresholds->linear[r][t] = (float)(2.0 * (q[r] * q[t] + q[s] * q[3]) / length * scale);
        thresholds->shift[r] = (float)qcRandom_Uniform(random, -4.0, 4.0);
    }
    // The transpose, over the square of the scale.
    for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++)
        {
            back[c][r] = 0.0;
            for (int s = 0; s < 3; s++)
                back[c][r] +=
                    (double)thresholds->linear[s][r] * (b[c][s] - (double)thresholds->shift[s]) / (scale * scale);
        }
}

#endif
