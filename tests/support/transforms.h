// Linear maps for rigid bodies: rotations, reflections, shears, nearly singular maps.
#ifndef QC_TESTS_SUPPORT_TRANSFORMS_H
#define QC_TESTS_SUPPORT_TRANSFORMS_H

#include "support/soups.h"

#include <math.h>
#include <string.h>

typedef enum qcShape
{
    qc_shapeRotated,
    qc_shapeScaled,  ///< along the axes
    qc_shapeSheared, ///< exactly, by small integers
    qc_shapeMirrored,
    qc_shapePlate,  ///< thin in one direction, by the share
    qc_shapeNeedle, ///< thin in two
    qc_shapeCount
} qcShape;

static inline void qcMultiplyLinear(const double a[9], const double b[9], double product[9])
{
    for (int i = 0; i < 9; i++)
        product[i] = a[i / 3 * 3] * b[i % 3] + a[i / 3 * 3 + 1] * b[i % 3 + 3] + a[i / 3 * 3 + 2] * b[i % 3 + 6];
}

static inline void qcMakeRotation(qcRandom* random, double m[9])
{
    double q[4], length = 0.0;
    for (int i = 0; i < 4; i++)
    {
        q[i] = qcRandom_Uniform(random, -1.0, 1.0);
        length += q[i] * q[i];
    }
    double s = 2.0 / length, x = q[0], y = q[1], z = q[2], w = q[3];
    const double r[9] = {1.0 - s * (y * y + z * z), s * (x * y - z * w),       s * (x * z + y * w),
                         s * (x * y + z * w),       1.0 - s * (x * x + z * z), s * (y * z - x * w),
                         s * (x * z - y * w),       s * (y * z + x * w),       1.0 - s * (x * x + y * y)};
    memcpy(m, r, sizeof r);
}

/// `share`: the ratio of thickness and width of plates and needles.
static inline void qcMakeLinear(qcRandom* random, qcShape shape, double share, double scale, double m[9])
{
    double left[9], right[9], half[9], middle[9] = {0.0};
    qcMakeRotation(random, left);
    qcMakeRotation(random, right);
    for (int k = 0; k < 3; k++)
    {
        bool flat = (shape == qc_shapePlate && k == 0) || (shape == qc_shapeNeedle && k != 0);
        middle[4 * k] = flat ? share : shape == qc_shapeRotated ? 1.0 : qcRandom_Uniform(random, 0.2, 2.0);
    }
    middle[0] = shape == qc_shapeMirrored ? -middle[0] : middle[0];
    qcMultiplyLinear(left, middle, half);
    qcMultiplyLinear(half, right, m);
    for (int i = 0; i < 9 && (shape == qc_shapeScaled || shape == qc_shapeSheared); i++)
        m[i] = shape == qc_shapeScaled ? middle[i]
               : i % 4 == 0            ? 1.0
               : i % 3 > i / 3         ? qcRandom_Integer(random, -3, 3)
                                       : 0.0;
    for (int i = 0; i < 9; i++)
        m[i] *= scale;
}

/// A map of a random shape, scaled by a random power of two.
static inline void qcMakeAnyLinear(qcRandom* random, int minExponent, int maxExponent, double m[9])
{
    double share = exp2(-qcRandom_Uniform(random, 0.0, 11.0));
    double scale = ldexp(1.0, (int)qcRandom_Integer(random, minExponent, maxExponent));
    qcMakeLinear(random, (qcShape)qcRandom_Below(random, qc_shapeCount), share, scale, m);
}

#endif
