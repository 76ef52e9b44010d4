// Failures with a message that names the place.
#ifndef QC_BASE_STATUS_H
#define QC_BASE_STATUS_H

#include "quickcullide/base.h"

/// qc_statusOutOfMemory, with a message that gives the size and the purpose of the memory.
qcStatus qcFailMemory(size_t size, const char* purpose);

/// Sends a line to the host's log function, if there is one.
__attribute__((format(printf, 1, 2))) void qcLog(const char* format, ...);

/// Whether there is one.
bool qcHasLog(void);

/// Returns from the calling function if a call fails, with the call's status.
#define QC_TRY(call)                                                                                                   \
    do                                                                                                                 \
    {                                                                                                                  \
        qcStatus tried = (call);                                                                                       \
        if (tried != qc_statusOk)                                                                                      \
            return tried;                                                                                              \
    } while (0)

#endif
