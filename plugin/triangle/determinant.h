// Signs and values of small determinants in integer arithmetic, for what the floating-point filter can't decide.
#ifndef QC_TRIANGLE_DETERMINANT_H
#define QC_TRIANGLE_DETERMINANT_H

/// A real number as mantissa * 2^exponent; the mantissa is 0 or within [1/2, 1) in magnitude.
typedef struct qcScaled
{
    double mantissa;
    int exponent;
} qcScaled;

/// det(b - a, c - a, d - a), its sign exact, its value within 2^-52 relative. Any finite coordinates.
qcScaled qcExactDeterminant3(const double a[3], const double b[3], const double c[3], const double d[3]);

/// Sign of det(b - a, c - a) in two coordinates. Any finite coordinates.
int qcExactSign2(double ax, double ay, double bx, double by, double cx, double cy);

#endif
