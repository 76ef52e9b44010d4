// The distance of two triangles as a quadratic program, in integers: the minimum of |sum l[i] A[i] - sum m[j] B[j]|^2
// over all weights l, m >= 0 that sum to 1 each. By active sets: Theil and van de Panne 1960. Proof:
// plugin/docs/proofs/oracle.md.
#include "support/oracle.h"
#include "support/oracle_integers.h"

#include <math.h>
#include <stdlib.h>

enum
{
    qc_corners = 6,
    qc_maxVectors = 3,
    // More than the 53 bits of a double.
    qc_rootBits = 64
};

struct qcOracleDistance
{
    mpz_t numerator, denominator; // of the squared distance, in units of 2^(2 exponent)
    int exponent;
};

// Coordinates in units of 2^result, relative to the first corner.
static int SetCorners(mpz_t corners[qc_corners][3], const double a[3][3], const double b[3][3])
{
    mpz_t* integers[3 * qc_corners];
    const double* values[3 * qc_corners];
    for (int i = 0; i < 3 * qc_corners; ++i)
    {
        integers[i] = &corners[i / 3][i % 3];
        values[i] = i < 9 ? &a[i / 3][i % 3] : &b[i / 3 - 3][i % 3];
        mpz_init(*integers[i]);
    }
    int exponent = qcOracle_ToIntegers(integers, values, 3 * qc_corners);
    for (int i = qc_corners - 1; i >= 0; --i)
        for (int axis = 0; axis < 3; ++axis)
            mpz_sub(corners[i][axis], corners[i][axis], corners[0][axis]);
    return exponent;
}

static void ClearCorners(mpz_t corners[qc_corners][3])
{
    for (int i = 0; i < qc_corners; ++i)
        mpz_clears(corners[i][0], corners[i][1], corners[i][2], NULL);
}

static void Dot(mpz_t dot, const mpz_t p[3], const mpz_t q[3])
{
    mpz_mul(dot, p[0], q[0]);
    mpz_addmul(dot, p[1], q[1]);
    mpz_addmul(dot, p[2], q[2]);
}

// sqrt(numerator / denominator) * 2^exponent
static double Root(const mpz_t numerator, const mpz_t denominator, int exponent)
{
    if (mpz_sgn(numerator) == 0)
        return 0;
    int shift = 2 * qc_rootBits + (int)mpz_sizeinbase(denominator, 2) - (int)mpz_sizeinbase(numerator, 2);
    shift += shift & 1;
    mpz_t quotient;
    mpz_init(quotient);
    if (shift >= 0)
        mpz_mul_2exp(quotient, numerator, (mp_bitcnt_t)shift);
    else
        mpz_tdiv_q_2exp(quotient, numerator, (mp_bitcnt_t)-shift);
    mpz_tdiv_q(quotient, quotient, denominator);
    mpz_sqrt(quotient, quotient);
    double root = ldexp(mpz_get_d(quotient), exponent - shift / 2);
    mpz_clear(quotient);
    return root;
}

//  ---- normal equations ------------------------------------------------------------------------------------

// Inner products of all corners, and the equations of one choice of I and J.
typedef struct Program
{
    mpz_t product[qc_corners][qc_corners];
    // One column more than vectors: minus the inner products with the difference of the first corners.
    mpz_t matrix[qc_maxVectors][qc_maxVectors + 1];
    mpz_t solution[qc_maxVectors], determinant, value, constant, left, right;
} Program;

static void Program_Init(Program* p, const mpz_t corners[qc_corners][3])
{
    for (int i = 0; i < qc_corners; ++i)
        for (int j = 0; j < qc_corners; ++j)
        {
            mpz_init(p->product[i][j]);
            Dot(p->product[i][j], corners[i], corners[j]);
        }
    for (int i = 0; i < qc_maxVectors; ++i)
    {
        mpz_init(p->solution[i]);
        for (int j = 0; j <= qc_maxVectors; ++j)
            mpz_init(p->matrix[i][j]);
    }
    mpz_inits(p->determinant, p->value, p->constant, p->left, p->right, NULL);
}

static void Program_Clear(Program* p)
{
    for (int i = 0; i < qc_corners; ++i)
        for (int j = 0; j < qc_corners; ++j)
            mpz_clear(p->product[i][j]);
    for (int i = 0; i < qc_maxVectors; ++i)
    {
        mpz_clear(p->solution[i]);
        for (int j = 0; j <= qc_maxVectors; ++j)
            mpz_clear(p->matrix[i][j]);
    }
    mpz_clears(p->determinant, p->value, p->constant, p->left, p->right, NULL);
}

// (p - q) . (r - s) by the corners' numbers.
static void ProductOf(mpz_t out, const Program* program, const int p[2], const int r[2])
{
    mpz_sub(out, program->product[p[0]][r[0]], program->product[p[0]][r[1]]);
    mpz_sub(out, out, program->product[p[1]][r[0]]);
    mpz_add(out, out, program->product[p[1]][r[1]]);
}

// The determinant of the first `count` columns, where the last one replaces column `replaced` (-1: none).
static void Determinant(mpz_t out, Program* p, int count, int replaced)
{
    int c[qc_maxVectors];
    for (int i = 0; i < qc_maxVectors; ++i)
        c[i] = i == replaced ? qc_maxVectors : i;
    if (count < 3)
    {
        mpz_set_ui(out, 1);
        if (count > 0)
            mpz_set(out, p->matrix[0][c[0]]);
        if (count > 1)
        {
            mpz_mul(out, out, p->matrix[1][c[1]]);
            mpz_submul(out, p->matrix[0][c[1]], p->matrix[1][c[0]]);
        }
        return;
    }
    mpz_set_ui(out, 0);
    for (int i = 0; i < 3; ++i)
    {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        mpz_mul(p->left, p->matrix[1][c[j]], p->matrix[2][c[k]]);
        mpz_submul(p->left, p->matrix[1][c[k]], p->matrix[2][c[j]]);
        mpz_addmul(out, p->matrix[0][c[i]], p->left);
    }
}

// True if no weight is negative: those of the vectors from `first` on, and the remainder for the first corner.
static bool AreWeights(Program* p, int first, int end)
{
    mpz_set_ui(p->left, 0);
    for (int i = first; i < end; ++i)
    {
        if (mpz_sgn(p->solution[i]) < 0)
            return false;
        mpz_add(p->left, p->left, p->solution[i]);
    }
    return mpz_cmp(p->left, p->determinant) <= 0;
}

static int Members(unsigned set, int offset, int members[3])
{
    int count = 0;
    for (int i = 0; i < 3; ++i)
        if ((set >> i & 1u) != 0)
            members[count++] = offset + i;
    return count;
}

// The closest points of the affine hulls of two sets of corners, if they lie within the convex hulls: the squared
// distance is value / determinant.
static bool Solve(Program* p, unsigned setA, unsigned setB)
{
    int i[3], j[3], vectors[4][2], count = 0;
    int countA = Members(setA, 0, i), countB = Members(setB, 3, j);
    if (countA + countB - 2 > qc_maxVectors)
        return false;
    for (int k = 1; k < countA; ++k, ++count)
    {
        vectors[count][0] = i[k];
        vectors[count][1] = i[0];
    }
    for (int k = 1; k < countB; ++k, ++count)
    {
        vectors[count][0] = j[0];
        vectors[count][1] = j[k];
    }
    const int difference[2] = {i[0], j[0]}, opposite[2] = {j[0], i[0]};
    for (int r = 0; r < count; ++r)
    {
        for (int c = 0; c < count; ++c)
            ProductOf(p->matrix[r][c], p, vectors[r], vectors[c]);
        ProductOf(p->matrix[r][qc_maxVectors], p, vectors[r], opposite);
    }
    Determinant(p->determinant, p, count, -1);
    if (mpz_sgn(p->determinant) == 0)
        return false;
    for (int k = 0; k < count; ++k)
        Determinant(p->solution[k], p, count, k);
    if (!AreWeights(p, 0, countA - 1) || !AreWeights(p, countA - 1, count))
        return false;
    ProductOf(p->constant, p, difference, difference);
    mpz_mul(p->value, p->constant, p->determinant);
    for (int k = 0; k < count; ++k)
        mpz_submul(p->value, p->solution[k], p->matrix[k][qc_maxVectors]);
    return true;
}

qcOracleDistance* qcOracleDistance_Create(const double a[3][3], const double b[3][3])
{
    qcOracleDistance* d = malloc(sizeof *d);
    if (d == NULL)
        abort();
    mpz_t corners[qc_corners][3];
    Program p;
    d->exponent = SetCorners(corners, a, b);
    mpz_init(d->numerator);
    mpz_init_set_ui(d->denominator, 0);
    Program_Init(&p, (const mpz_t(*)[3])corners);
    for (unsigned sets = 0; sets < 64; ++sets)
    {
        if ((sets & 7u) == 0 || sets >> 3 == 0 || !Solve(&p, sets & 7u, sets >> 3))
            continue;
        mpz_mul(p.left, p.value, d->denominator);
        mpz_mul(p.right, p.determinant, d->numerator);
        if (mpz_sgn(d->denominator) == 0 || mpz_cmp(p.left, p.right) < 0)
        {
            mpz_set(d->numerator, p.value);
            mpz_set(d->denominator, p.determinant);
        }
    }
    Program_Clear(&p);
    ClearCorners(corners);
    return d;
}

void qcOracleDistance_Destroy(qcOracleDistance* distance)
{
    mpz_clears(distance->numerator, distance->denominator, NULL);
    free(distance);
}

int qcOracleDistance_Compare(const qcOracleDistance* distance, double margin)
{
    mpz_t left, right;
    mpz_inits(left, right, NULL);
    int exponent = qcOracle_ToIntegers((mpz_t* const[]){&right}, (const double* const[]){&margin}, 1);
    mpz_mul(right, right, right);
    mpz_mul(right, right, distance->denominator);
    int shift = 2 * (exponent - distance->exponent);
    mpz_mul_2exp(right, right, (mp_bitcnt_t)(shift > 0 ? shift : 0));
    mpz_mul_2exp(left, distance->numerator, (mp_bitcnt_t)(shift < 0 ? -shift : 0));
    int sign = mpz_cmp(left, right);
    mpz_clears(left, right, NULL);
    return (sign > 0) - (sign < 0);
}

double qcOracleDistance_Get(const qcOracleDistance* distance)
{
    return Root(distance->numerator, distance->denominator, distance->exponent);
}

//  ---- depth -------------------------------------------------------------------------------------------------

typedef struct Depth
{
    mpz_t numerator, denominator; // squared; denominator 0: no axis yet
} Depth;

// The overlap of the projections onto an axis, both ways.
static void TryAxis(Depth* depth, const mpz_t corners[qc_corners][3], const mpz_t axis[3])
{
    mpz_t length2, x, low[2], high[2], left, right;
    mpz_inits(length2, x, low[0], low[1], high[0], high[1], left, right, NULL);
    Dot(length2, axis, axis);
    for (int i = 0; i < qc_corners; ++i)
    {
        Dot(x, axis, corners[i]);
        if (i % 3 == 0 || mpz_cmp(x, low[i / 3]) < 0)
            mpz_set(low[i / 3], x);
        if (i % 3 == 0 || mpz_cmp(x, high[i / 3]) > 0)
            mpz_set(high[i / 3], x);
    }
    for (int way = 0; way < 2 && mpz_sgn(length2) != 0; ++way)
    {
        mpz_sub(x, high[way], low[1 - way]);
        mpz_mul(x, x, x);
        mpz_mul(left, x, depth->denominator);
        mpz_mul(right, length2, depth->numerator);
        if (mpz_sgn(depth->denominator) != 0 && mpz_cmp(left, right) >= 0)
            continue;
        mpz_set(depth->numerator, x);
        mpz_set(depth->denominator, length2);
    }
    mpz_clears(length2, x, low[0], low[1], high[0], high[1], left, right, NULL);
}

static void TryCross(Depth* depth, const mpz_t corners[qc_corners][3], const int p[2], const int q[2])
{
    mpz_t d[3], e[3], n[3];
    for (int axis = 0; axis < 3; ++axis)
    {
        mpz_inits(d[axis], e[axis], n[axis], NULL);
        mpz_sub(d[axis], corners[p[1]][axis], corners[p[0]][axis]);
        mpz_sub(e[axis], corners[q[1]][axis], corners[q[0]][axis]);
    }
    for (int axis = 0; axis < 3; ++axis)
    {
        int u = (axis + 1) % 3, v = (axis + 2) % 3;
        mpz_mul(n[axis], d[u], e[v]);
        mpz_submul(n[axis], d[v], e[u]);
    }
    TryAxis(depth, corners, (const mpz_t*)n);
    for (int axis = 0; axis < 3; ++axis)
        mpz_clears(d[axis], e[axis], n[axis], NULL);
}

double qcOracle_Depth(const double a[3][3], const double b[3][3])
{
    mpz_t corners[qc_corners][3];
    Depth depth;
    mpz_inits(depth.numerator, depth.denominator, NULL);
    int exponent = SetCorners(corners, a, b);
    for (int triangle = 0; triangle < qc_corners; triangle += 3)
        TryCross(&depth, (const mpz_t(*)[3])corners, (const int[]){triangle, triangle + 1},
                 (const int[]){triangle, triangle + 2});
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            TryCross(&depth, (const mpz_t(*)[3])corners, (const int[]){i, (i + 1) % 3},
                     (const int[]){3 + j, 3 + (j + 1) % 3});
    double result = mpz_sgn(depth.denominator) == 0 ? 0 : Root(depth.numerator, depth.denominator, exponent);
    mpz_clears(depth.numerator, depth.denominator, NULL);
    ClearCorners(corners);
    return result;
}
