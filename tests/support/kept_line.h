// A callback for lines of the library's log: the last one, and their number.
#ifndef QC_TESTS_SUPPORT_KEPT_LINE_H
#define QC_TESTS_SUPPORT_KEPT_LINE_H

#include <stdio.h>

static char s_line[512];
static int s_lines;

static void KeepLine(const char* line, void* context)
{
    (void)context;
    snprintf(s_line, sizeof s_line, "%s", line);
    s_lines++;
}

#endif
