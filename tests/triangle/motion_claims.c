// The claims about pairs in motion: see motion_claims.h.
#include "triangle/motion_claims.h"

#include "support/oracle.h"
#include "support/oracle_integers.h"

#include <string.h>

typedef struct Integers
{
    mpz_t corner[qc_cornerCount][3], direction[3], product, lowest, highest;
} Integers;

static void InitIntegers(Integers* x)
{
    mpz_inits(x->product, x->lowest, x->highest, NULL);
    for (int axis = 0; axis < 3; axis++)
    {
        mpz_init(x->direction[axis]);
        for (int i = 0; i < qc_cornerCount; i++)
            mpz_init(x->corner[i][axis]);
    }
}

static void ClearIntegers(Integers* x)
{
    mpz_clears(x->product, x->lowest, x->highest, NULL);
    for (int axis = 0; axis < 3; axis++)
    {
        mpz_clear(x->direction[axis]);
        for (int i = 0; i < qc_cornerCount; i++)
            mpz_clear(x->corner[i][axis]);
    }
}

bool qcClaim_IsAbove(const double direction[3], const double corners[qc_cornerCount][3])
{
    Integers numbers, *x = &numbers;
    InitIntegers(x);
    mpz_t* integers[3 * qc_cornerCount];
    const double* values[3 * qc_cornerCount];
    for (int axis = 0; axis < 3; axis++)
    {
        integers[axis] = &x->direction[axis];
        values[axis] = &direction[axis];
    }
    (void)qcOracle_ToIntegers(integers, values, 3);
    for (int i = 0; i < 3 * qc_cornerCount; i++)
    {
        integers[i] = &x->corner[i / 3][i % 3];
        values[i] = &corners[i / 3][i % 3];
    }
    (void)qcOracle_ToIntegers(integers, values, 3 * qc_cornerCount);
    for (int i = 0; i < qc_cornerCount; i++)
    {
        mpz_mul(x->product, x->direction[0], x->corner[i][0]);
        mpz_addmul(x->product, x->direction[1], x->corner[i][1]);
        mpz_addmul(x->product, x->direction[2], x->corner[i][2]);
        mpz_t* bound = i < 3 ? &x->lowest : &x->highest;
        if (i % 3 == 0 || (i < 3 ? mpz_cmp(x->product, *bound) < 0 : mpz_cmp(x->product, *bound) > 0))
            mpz_set(*bound, x->product);
    }
    bool isAbove = mpz_cmp(x->lowest, x->highest) > 0;
    ClearIntegers(x);
    return isAbove;
}

/// Whether the hulls of some corners have a common point.
static bool Meet(const double corners[qc_cornerCount][3], const int a[3], const int b[3])
{
    double p[3][3], q[3][3];
    for (int i = 0; i < 3; i++)
    {
        memcpy(p[i], corners[a[i]], sizeof p[i]);
        memcpy(q[i], corners[b[i]], sizeof q[i]);
    }
    return qcRelateTriangles(p[0], q[0]) != qc_relationDisjoint;
}

bool qcClaim_MeetElsewhere(const double corners[qc_cornerCount][3], int common)
{
    static const int a[3] = {0, 1, 2}, b[3] = {3, 4, 5}, edgeOfA[3] = {1, 2, 2}, edgeOfB[3] = {4, 5, 5},
                     cornerOfA[3] = {2, 2, 2}, cornerOfB[3] = {5, 5, 5}, firstA[3] = {0, 2, 2}, firstB[3] = {3, 5, 5};
    if (common == 0)
        return Meet(corners, a, b);
    if (common == 1)
        return Meet(corners, edgeOfA, b) || Meet(corners, edgeOfB, a);
    return Meet(corners, cornerOfA, b) || Meet(corners, cornerOfB, a) || Meet(corners, firstA, edgeOfB) ||
           Meet(corners, edgeOfA, firstB);
}

void qcClaim_GetPositions(const Pair* pair, int k, double corners[qc_cornerCount][3])
{
    for (int i = 0; i < qc_cornerCount; i++)
        for (int axis = 0; axis < 3; axis++)
            corners[i][axis] = (qc_times - k) * pair->at[0][i][axis] + k * pair->at[1][i][axis];
}
