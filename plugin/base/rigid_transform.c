// Inverse by cofactors, with an error bound. Proof: plugin/docs/proofs/rigid_transform.md.
#include "base/rigid_transform.h"

#include <math.h>

static const double s_maxCondition = 4096.0;

/// Largest sum of absolute values in a row.
static double RowSum(const double m[9])
{
    double largest = 0.0;
    for (size_t i = 0; i < 3; i++)
        largest = fmax(largest, fabs(m[3 * i]) + fabs(m[3 * i + 1]) + fabs(m[3 * i + 2]));
    return largest;
}

/// Returns the condition number, or infinity for a matrix that is not inverted.
static double Invert(const double m[9], double inverse[9])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
        {
            int r = (j + 1) % 3, s = (j + 2) % 3, u = (i + 1) % 3, v = (i + 2) % 3;
            inverse[3 * i + j] = m[3 * r + u] * m[3 * s + v] - m[3 * r + v] * m[3 * s + u];
        }
    double determinant = m[0] * inverse[0] + m[1] * inverse[3] + m[2] * inverse[6];
    for (int i = 0; i < 9; i++)
        inverse[i] /= determinant;
    double condition = RowSum(m) * RowSum(inverse);
    // Extreme scales overflow, or lose the determinant. A matrix that is nearly flat in two directions has a
    // determinant of rounding errors alone, some 2^-50 of the cube of its size, and an inverse that may look harmless;
    // accepted ones have 2^-36 or more.
    double size = RowSum(m);
    bool usable =
        size > 1e-60 && size < 1e60 && condition <= s_maxCondition && fabs(determinant) > 0x1p-36 * size * size * size;
    return usable ? condition : INFINITY;
}

bool qcTransform_IsInvertible(const qcTransform* transform)
{
    double inverse[9];
    return isfinite(Invert(transform->linear, inverse));
}

/// Bound for the terms of a body's world coordinates along an axis.
static double Size(const qcRigidTransform* p, int axis)
{
    double size = fabs(p->transform.translation[axis]);
    for (int k = 0; k < 3; k++)
        size += fabs(p->transform.linear[3 * axis + k]) * fmax(fabs(p->lower[k]), fabs(p->upper[k]));
    return size;
}

/// Upper bound for the 2-norm: its square is the norm of the product with the transpose.
static double FindNorm(const double m[9])
{
    double largest = 0.0;
    for (size_t i = 0; i < 3; i++)
    {
        const double* row = m + 3 * i;
        double sum = 0.0;
        for (size_t k = 0; k < 3; k++)
            sum += fabs(row[0] * m[3 * k] + row[1] * m[3 * k + 1] + row[2] * m[3 * k + 2]);
        largest = fmax(largest, sum);
    }
    return sqrt(largest) * (1.0 + 1e-8);
}

qcRelativeTransform qcRelativeTransform_Find(const qcRigidTransform* a, const qcRigidTransform* b)
{
    qcRelativeTransform r = {.stretch = 0.0};
    double inverse[9], condition = Invert(a->transform.linear, inverse);
    for (size_t i = 0; i < 3; i++)
    {
        const double* row = inverse + 3 * i;
        double size = 0.0;
        for (int j = 0; j < 3; j++)
        {
            r.shift[i] += row[j] * (b->transform.translation[j] - a->transform.translation[j]);
            size += fabs(row[j]) * (Size(a, j) + Size(b, j));
            r.reach[i] += fabs(row[j]);
            for (int k = 0; k < 3; k++)
                r.linear[i][k] += row[j] * b->transform.linear[3 * j + k];
        }
        // Products may underflow, each by 2^-1074 and then times the inverse, at most 2^212.
        r.error[i] = 0x1p-46 * condition * size + 1e-200;
    }
    r.stretch = FindNorm(inverse);
    r.growth = FindNorm(a->transform.linear);
    return r;
}
