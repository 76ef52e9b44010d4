// The status of several calls that all have to be made.
#ifndef QC_GLUE_COMMON_FIRST_ERROR_H
#define QC_GLUE_COMMON_FIRST_ERROR_H

#include "quickcullide/base.h"

inline qcStatus qcFirstError(qcStatus first, qcStatus second)
{
    return first != qc_statusOk ? first : second;
}

#endif
