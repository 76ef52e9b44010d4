// A message for the user: the reason of a failure.
#ifndef QC_DEMOS_COMMON_MESSAGE_H
#define QC_DEMOS_COMMON_MESSAGE_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct qcMessage
{
    char text[1024];
} qcMessage;

/// Keeps a printf-style message, cut where it is too long. Returns false, so that a failing function can return it.
__attribute__((format(printf, 2, 3))) bool qcMessage_Fail(qcMessage* message, const char* format, ...);

#ifdef __cplusplus
}
#endif

#endif
