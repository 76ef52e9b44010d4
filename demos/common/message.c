// A message for the user: the reason of a failure.
#include "common/message.h"

#include <stdarg.h>
#include <stdio.h>

bool qcMessage_Fail(qcMessage* message, const char* format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message->text, sizeof message->text, format, arguments);
    va_end(arguments);
    return false;
}
