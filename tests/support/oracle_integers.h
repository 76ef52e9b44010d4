// Doubles as GMP integers: for the oracles among themselves.
#ifndef QC_TESTS_SUPPORT_ORACLE_INTEGERS_H
#define QC_TESTS_SUPPORT_ORACLE_INTEGERS_H

#include <gmp.h>

enum
{
    // Six corners and a margin.
    qc_oracleMaxIntegers = 19
};

// *integers[i] * 2^result = *values[i], as small as a common power of two allows.
int qcOracle_ToIntegers(mpz_t* const integers[], const double* const values[], int count);

#endif
