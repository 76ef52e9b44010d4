// Where rigid bodies are: their boxes, and what goes from one body's coordinates to another's, against long double and
// against the vertices themselves; then whole scenes of rigid bodies against brute force.
#include "placement.h"

#include "scenes.h"
#include "status.h"
#include "suite.h"
#include "surfaces.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

//  ---- transforms ----------------------------------------------------------------------------------

typedef enum Shape
{
    shapeRotation,
    shapeScaled,   ///< by axis, in coordinates of its own
    shapeMirrored, ///< by axis, and turned
    shapeSheared,  ///< by small integers: exact
    shapeThin,     ///< nearly flattened: one direction, up to the limit
    shapeNeedle,   ///< and two
    shapeCount
} Shape;

static void Multiply(const double a[9], const double b[9], double product[9])
{
    for (int i = 0; i < 9; i++)
        product[i] = a[i / 3 * 3] * b[i % 3] + a[i / 3 * 3 + 1] * b[i % 3 + 3] + a[i / 3 * 3 + 2] * b[i % 3 + 6];
}

static void MakeRotation(qcRandom* random, double m[9])
{
    double q[4], length = 0.0;
    for (int i = 0; i < 4; i++)
    {
        q[i] = qcRandom_Uniform(random, -1.0, 1.0);
        length += q[i] * q[i];
    }
    double s = 2.0 / length, x = q[0], y = q[1], z = q[2], w = q[3];
    const double r[9] = {1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w),
                         s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w),
                         s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)};
    memcpy(m, r, sizeof r);
}

/// Of a shape, `scale` large.
static void MakeLinear(qcRandom* random, Shape shape, double scale, double m[9])
{
    double left[9], right[9], middle[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}, product[9];
    MakeRotation(random, left);
    MakeRotation(random, right);
    for (int k = 0; k < 3; k++)
        switch (shape)
        {
            case shapeScaled:
            case shapeMirrored: middle[4 * k] = qcRandom_Uniform(random, 0.2, 5.0); break;
            // Row sums are up to three times the 2-norm.
            case shapeThin: middle[4 * k] = k == 0 ? 1.0 / qcRandom_Uniform(random, 10.0, 4000.0) : 1.0; break;
            case shapeNeedle: middle[4 * k] = k == 0 ? 1.0 : 1.0 / qcRandom_Uniform(random, 10.0, 4000.0); break;
            default: break;
        }
    if (shape == shapeMirrored)
        middle[0] = -middle[0];
    if (shape == shapeSheared)
    {
        for (int i = 0; i < 9; i++)
            left[i] = i % 4 == 0 ? 1.0 : i % 3 > i / 3 ? qcRandom_Integer(random, -3, 3) : 0.0;
        memcpy(right, middle, sizeof right);
    }
    else if (shape == shapeScaled)
        memcpy(right, left, 0), memcpy(left, (const double[9]){1, 0, 0, 0, 1, 0, 0, 0, 1}, sizeof left);
    Multiply(left, middle, product);
    Multiply(product, right, m);
    for (int i = 0; i < 9; i++)
        m[i] *= scale;
}
