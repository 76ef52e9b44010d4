// The rows of a CSV with a header, for tests of the tools that write one.
#ifndef QC_TESTS_SUPPORT_CSV_ROWS_H
#define QC_TESTS_SUPPORT_CSV_ROWS_H

#include "support/run_program.h"

#include <check.h>
#include <stdlib.h>
#include <string.h>

enum
{
    qc_maxFields = 64
};

typedef struct Row
{
    const char* header;
    char line[1024];
    const char* fields[qc_maxFields];
    int count;
} Row;

/// Splits a line; a comma in quotes is text.
static inline void Split(const char* text, Row* row)
{
    size_t length = strcspn(text, "\n");
    ck_assert_uint_lt(length, sizeof row->line);
    memcpy(row->line, text, length);
    row->line[length] = 0;
    row->count = 0;
    row->fields[row->count++] = row->line;
    bool quoted = false;
    for (char* c = row->line; *c != 0; ++c)
    {
        quoted ^= *c == '"';
        if (*c != ',' || quoted)
            continue;
        ck_assert_int_lt(row->count, qc_maxFields);
        *c = 0;
        row->fields[row->count++] = c + 1;
    }
}

static inline const char* Get(const Row* row, const char* column)
{
    Row header;
    Split(row->header, &header);
    for (int i = 0; i < header.count; ++i)
    {
        if (strcmp(header.fields[i], column) == 0)
            return row->fields[i];
    }
    ck_abort_msg("no column %s", column);
    return NULL;
}

static inline double GetNumber(const Row* row, const char* column)
{
    char* end;
    const char* text = Get(row, column);
    double value = strtod(text, &end);
    ck_assert_msg(end != text && *end == 0, "%s is '%s'", column, text);
    return value;
}

static inline bool Is(const Row* row, const char* column, const char* value)
{
    return strcmp(Get(row, column), value) == 0;
}

/// Calls a function for each row of the file, whose header must be the given one. Returns the number of rows.
static inline int ForEachRow(const char* path, const char* header, void (*take)(const Row* row, void* context),
                             void* context)
{
    static char s_text[1 << 18];
    size_t length = strlen(header);
    ck_assert(ReadText(path, s_text, sizeof s_text));
    ck_assert_uint_eq(strcspn(s_text, "\n"), length);
    ck_assert_int_eq(strncmp(s_text, header, length), 0);
    Row first;
    Split(header, &first);
    int count = 0;
    for (const char* line = strchr(s_text, '\n') + 1; *line != 0; line = strchr(line, '\n') + 1, ++count)
    {
        Row row = {.header = header};
        Split(line, &row);
        ck_assert_int_eq(row.count, first.count);
        take(&row, context);
    }
    return count;
}

#endif
