// Statuses and messages. Each thread has its own last message, so that scenes on two threads don't mix theirs.
#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>

static _Thread_local char s_message[512];
static qcLogFunction* s_log;
static void* s_logContext;

const char* qcLastMessage(void)
{
    return s_message;
}

const char* qcStatus_Name(qcStatus status)
{
    switch (status)
    {
        case qc_statusOk: return "ok";
        case qc_statusBadInput: return "bad input";
        case qc_statusDevice: return "device";
        case qc_statusOutOfMemory: return "out of memory";
        case qc_statusDeviceLost: return "device lost";
        case qc_statusFile: return "file";
        case qc_statusTooManyPairs: return "too many pairs";
    }
    return "unknown status";
}

void qcSetLog(qcLogFunction* log, void* context)
{
    s_log = log;
    s_logContext = context;
}

void qcLog(const char* format, ...)
{
    if (s_log == NULL)
        return;
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    s_log(line, s_logContext);
}

bool qcHasLog(void)
{
    return s_log != NULL;
}

qcStatus qcFail(qcStatus status, const char* format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(s_message, sizeof s_message, format, arguments);
    va_end(arguments);
    return status;
}

qcStatus qcFailMemory(size_t size, const char* purpose)
{
    return qcFail(qc_statusOutOfMemory, "out of memory: %zu bytes for %s", size, purpose);
}
