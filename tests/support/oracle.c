// The relation of two triangles from the vertices of a polytope, in integer arithmetic without geometric cases.
// Rockafellar, Convex Analysis (1970), theorem 6.9; vertices by integer pivoting: Edmonds 1967, Bareiss 1968.
// Proof: plugin/docs/proofs/oracle.md.
#include "support/oracle.h"

#include "support/oracle_integers.h"

#include <math.h>

enum
{
    qc_unknowns = 6,
    qc_rightHandSide = qc_unknowns,
    qc_equations = 5
};

// A row i with a basic column b is the equation divisor * x[b] + sum over the other columns = right-hand side.
typedef struct Tableau
{
    mpz_t entry[qc_equations][qc_unknowns + 1];
    int basic[qc_equations];
    int rowCount;
    mpz_t divisor;
    mpz_t factor, product;
} Tableau;

static void Tableau_Init(Tableau* t)
{
    for (int i = 0; i < qc_equations; ++i)
        for (int j = 0; j <= qc_unknowns; ++j)
            mpz_init(t->entry[i][j]);
    t->rowCount = qc_equations;
    mpz_init_set_ui(t->divisor, 1);
    mpz_inits(t->factor, t->product, NULL);
}

static void Tableau_Clear(Tableau* t)
{
    for (int i = 0; i < qc_equations; ++i)
        for (int j = 0; j <= qc_unknowns; ++j)
            mpz_clear(t->entry[i][j]);
    mpz_clears(t->divisor, t->factor, t->product, NULL);
}

int qcOracle_ToIntegers(mpz_t* const integers[], const double* const values[], int count)
{
    int exponents[qc_oracleMaxIntegers];
    double mantissas[qc_oracleMaxIntegers];
    int smallest = 0;
    bool any = false;
    for (int i = 0; i < count; ++i)
    {
        mantissas[i] = ldexp(frexp(*values[i], &exponents[i]), 53);
        exponents[i] -= 53;
        if (mantissas[i] != 0 && (!any || exponents[i] < smallest))
        {
            smallest = exponents[i];
            any = true;
        }
    }
    for (int i = 0; i < count; ++i)
    {
        mpz_set_d(*integers[i], mantissas[i]);
        if (mantissas[i] != 0)
            mpz_mul_2exp(*integers[i], *integers[i], (mp_bitcnt_t)(exponents[i] - smallest));
    }
    return smallest;
}

// Each entry is a minor of the first tableau: the division is exact.
static void Tableau_Pivot(Tableau* t, int row, int column)
{
    mpz_t* pivotRow = t->entry[row];
    for (int i = 0; i < t->rowCount; ++i)
    {
        if (i == row)
            continue;
        mpz_set(t->factor, t->entry[i][column]);
        for (int j = 0; j <= qc_unknowns; ++j)
        {
            mpz_mul(t->product, t->entry[i][j], pivotRow[column]);
            mpz_submul(t->product, t->factor, pivotRow[j]);
            mpz_divexact(t->entry[i][j], t->product, t->divisor);
        }
    }
    mpz_set(t->divisor, pivotRow[column]);
    t->basic[row] = column;
}

// Gives each row a basic column and removes redundant rows. False: the equations are inconsistent.
static bool Tableau_FindBasis(Tableau* t)
{
    int row = 0;
    while (row < t->rowCount)
    {
        int column = 0;
        while (column < qc_unknowns && mpz_sgn(t->entry[row][column]) == 0)
            ++column;
        if (column < qc_unknowns)
        {
            Tableau_Pivot(t, row, column);
            ++row;
            continue;
        }
        if (mpz_sgn(t->entry[row][qc_rightHandSide]) != 0)
            return false;
        --t->rowCount;
        for (int j = 0; j <= qc_unknowns; ++j)
            mpz_swap(t->entry[row][j], t->entry[t->rowCount][j]);
    }
    return true;
}

// Exchanges columns until the basis is `target`. False: those columns are linearly dependent.
static bool Tableau_MoveTo(Tableau* t, unsigned target)
{
    unsigned missing = target;
    for (int i = 0; i < t->rowCount; ++i)
        missing &= ~(1u << t->basic[i]);
    for (int column = 0; column < qc_unknowns; ++column)
    {
        if ((missing >> column & 1u) == 0)
            continue;
        int row = 0;
        while (row < t->rowCount && ((target >> t->basic[row] & 1u) != 0 || mpz_sgn(t->entry[row][column]) == 0))
            ++row;
        if (row == t->rowCount)
            return false;
        Tableau_Pivot(t, row, column);
    }
    return true;
}

// The unknowns that are positive in the basic solution, as a set; empty if one is negative.
static unsigned Tableau_GetSupport(const Tableau* t)
{
    unsigned support = 0;
    for (int i = 0; i < t->rowCount; ++i)
    {
        int sign = mpz_sgn(t->entry[i][qc_rightHandSide]) * mpz_sgn(t->divisor);
        if (sign < 0)
            return 0;
        if (sign > 0)
            support |= 1u << t->basic[i];
    }
    return support;
}

static int CountBits(unsigned set)
{
    int count = 0;
    for (; set != 0; set &= set - 1)
        ++count;
    return count;
}

// A rational number, scaled by 2^exponent, rounded toward zero.
static double ToDouble(mpz_t numerator, const mpz_t denominator, int exponent)
{
    mpq_t q;
    mpq_init(q);
    mpz_set(mpq_numref(q), numerator);
    mpz_set(mpq_denref(q), denominator);
    if (exponent > 0)
        mpz_mul_2exp(mpq_numref(q), mpq_numref(q), (mp_bitcnt_t)exponent);
    else
        mpz_mul_2exp(mpq_denref(q), mpq_denref(q), (mp_bitcnt_t)-exponent);
    mpq_canonicalize(q);
    double result = mpq_get_d(q);
    mpq_clear(q);
    return result;
}

typedef struct Corners
{
    mpz_t coordinate[3][3];
    int exponent[3];
} Corners;

static void AddPoint(Tableau* t, const Corners* a, qcOracleAnswer* answer)
{
    double* point = answer->points[answer->pointCount];
    for (int axis = 0; axis < 3; ++axis)
    {
        mpz_set_ui(t->product, 0);
        for (int i = 0; i < t->rowCount; ++i)
            if (t->basic[i] < 3)
                mpz_addmul(t->product, t->entry[i][qc_rightHandSide], a->coordinate[t->basic[i]][axis]);
        point[axis] = ToDouble(t->product, t->divisor, a->exponent[axis]);
    }
    for (int i = 0; i < answer->pointCount; ++i)
        if (answer->points[i][0] == point[0] && answer->points[i][1] == point[1] && answer->points[i][2] == point[2])
            return;
    ++answer->pointCount;
}

// Visits the vertices of P. Without a list of points to fill, it stops once penetration is proven.
static qcRelation VisitVertices(Tableau* t, const Corners* a, qcOracleAnswer* answer)
{
    const unsigned all = (1u << qc_unknowns) - 1;
    unsigned positive = 0;
    for (unsigned basis = 1; basis <= all; ++basis)
    {
        if (CountBits(basis) != t->rowCount || !Tableau_MoveTo(t, basis))
            continue;
        unsigned support = Tableau_GetSupport(t);
        positive |= support;
        if (support != 0 && answer != NULL)
            AddPoint(t, a, answer);
        if (positive == all && answer == NULL)
            break;
    }
    return positive == 0 ? qc_relationDisjoint : positive == all ? qc_relationPenetrating : qc_relationTouching;
}

static void SetEquations(Tableau* t, Corners* corners, const double a[3][3], const double b[3][3])
{
    for (int i = 0; i < 3; ++i)
    {
        mpz_set_ui(t->entry[0][i], 1);
        mpz_set_ui(t->entry[1][3 + i], 1);
    }
    mpz_set_ui(t->entry[0][qc_rightHandSide], 1);
    mpz_set_ui(t->entry[1][qc_rightHandSide], 1);
    for (int axis = 0; axis < 3; ++axis)
    {
        mpz_t* row = t->entry[2 + axis];
        const double* values[] = {&a[0][axis], &a[1][axis], &a[2][axis], &b[0][axis], &b[1][axis], &b[2][axis]};
        mpz_t* integers[] = {&row[0], &row[1], &row[2], &row[3], &row[4], &row[5]};
        corners->exponent[axis] = qcOracle_ToIntegers(integers, values, 6);
        for (int i = 0; i < 3; ++i)
        {
            mpz_set(corners->coordinate[i][axis], row[i]);
            mpz_neg(row[3 + i], row[3 + i]);
        }
    }
}

static bool BoxesMeet(const double a[3][3], const double b[3][3])
{
    for (int axis = 0; axis < 3; ++axis)
    {
        double lowerA = fmin(fmin(a[0][axis], a[1][axis]), a[2][axis]);
        double upperA = fmax(fmax(a[0][axis], a[1][axis]), a[2][axis]);
        double lowerB = fmin(fmin(b[0][axis], b[1][axis]), b[2][axis]);
        double upperB = fmax(fmax(b[0][axis], b[1][axis]), b[2][axis]);
        if (upperA < lowerB || upperB < lowerA)
            return false;
    }
    return true;
}

static qcRelation Solve(const double a[3][3], const double b[3][3], qcOracleAnswer* answer)
{
    if (!BoxesMeet(a, b))
        return qc_relationDisjoint;
    Tableau t;
    Corners corners;
    Tableau_Init(&t);
    for (int i = 0; i < 3; ++i)
        mpz_inits(corners.coordinate[i][0], corners.coordinate[i][1], corners.coordinate[i][2], NULL);
    SetEquations(&t, &corners, a, b);
    qcRelation relation = Tableau_FindBasis(&t) ? VisitVertices(&t, &corners, answer) : qc_relationDisjoint;
    for (int i = 0; i < 3; ++i)
        mpz_clears(corners.coordinate[i][0], corners.coordinate[i][1], corners.coordinate[i][2], NULL);
    Tableau_Clear(&t);
    return relation;
}

qcRelation qcOracle_Relate(const double a[3][3], const double b[3][3])
{
    return Solve(a, b, NULL);
}

void qcOracle_Intersect(const double a[3][3], const double b[3][3], qcOracleAnswer* answer)
{
    answer->pointCount = 0;
    answer->relation = Solve(a, b, answer);
}

// Each axis has its own scale, which multiplies the determinant by a positive factor.
static void SetDifferences(mpz_t* const differences[], const double* const values[], int count)
{
    qcOracle_ToIntegers(differences, values, count);
    for (int i = 1; i < count; ++i)
        mpz_sub(*differences[i], *differences[i], *differences[0]);
}

int qcOracle_Orient3d(const double a[3], const double b[3], const double c[3], const double d[3])
{
    mpz_t m[3][4], minor, determinant;
    mpz_inits(minor, determinant, NULL);
    for (int axis = 0; axis < 3; ++axis)
    {
        mpz_inits(m[axis][0], m[axis][1], m[axis][2], m[axis][3], NULL);
        SetDifferences((mpz_t* const[]){&m[axis][0], &m[axis][1], &m[axis][2], &m[axis][3]},
                       (const double* const[]){&a[axis], &b[axis], &c[axis], &d[axis]}, 4);
    }
    for (int axis = 0; axis < 3; ++axis)
    {
        mpz_t* y = m[(axis + 1) % 3];
        mpz_t* z = m[(axis + 2) % 3];
        mpz_mul(minor, y[2], z[3]);
        mpz_submul(minor, y[3], z[2]);
        mpz_addmul(determinant, m[axis][1], minor);
    }
    int sign = mpz_sgn(determinant);
    for (int axis = 0; axis < 3; ++axis)
        mpz_clears(m[axis][0], m[axis][1], m[axis][2], m[axis][3], NULL);
    mpz_clears(minor, determinant, NULL);
    return sign;
}

int qcOracle_Orient2d(const double a[3], const double b[3], const double c[3], int u, int v)
{
    mpz_t x[3], y[3], determinant;
    mpz_inits(x[0], x[1], x[2], y[0], y[1], y[2], determinant, NULL);
    SetDifferences((mpz_t* const[]){&x[0], &x[1], &x[2]}, (const double* const[]){&a[u], &b[u], &c[u]}, 3);
    SetDifferences((mpz_t* const[]){&y[0], &y[1], &y[2]}, (const double* const[]){&a[v], &b[v], &c[v]}, 3);
    mpz_mul(determinant, x[1], y[2]);
    mpz_submul(determinant, x[2], y[1]);
    int sign = mpz_sgn(determinant);
    mpz_clears(x[0], x[1], x[2], y[0], y[1], y[2], determinant, NULL);
    return sign;
}
