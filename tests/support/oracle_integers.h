// Doubles as GMP integers, shared by the oracles.
#ifndef QC_TESTS_SUPPORT_ORACLE_INTEGERS_H
#define QC_TESTS_SUPPORT_ORACLE_INTEGERS_H

#include <gmp.h>

enum
{
    // Six corners and a margin.
    qc_oracleMaxIntegers = 19
};

// Sets *integers[i] so that *integers[i] * 2^result = *values[i], with the largest possible result.
int qcOracle_ToIntegers(mpz_t* const integers[], const double* const values[], int count);

#endif
