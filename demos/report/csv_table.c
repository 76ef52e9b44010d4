// A CSV as a table of the page.
#include "report/report.h"

#include <stdlib.h>
#include <string.h>

/// The end of a row: a line feed outside of quotes, or the end of the text.
static const char* FindRowEnd(const char* row)
{
    bool isQuoted = false;
    for (; *row != 0 && (isQuoted || *row != '\n'); ++row)
        isQuoted ^= *row == '"';
    return row;
}

static const char* FindFieldEnd(const char* field, const char* rowEnd)
{
    bool isQuoted = false;
    for (; field < rowEnd && (isQuoted || *field != ','); ++field)
        isQuoted ^= *field == '"';
    return field;
}

static bool IsNumber(const char* text, size_t length)
{
    char copy[64];
    if (length == 0 || length >= sizeof copy)
        return length == 0;
    memcpy(copy, text, length);
    copy[length] = 0;
    char* end;
    strtod(copy, &end);
    return *end == 0 || strcmp(copy, "-") == 0;
}

/// Without the quotes around it; two quotes stand for one.
static void WriteField(FILE* page, const char* text, size_t length)
{
    if (length < 2 || text[0] != '"' || text[length - 1] != '"')
    {
        qcReport_WriteEscaped(page, text, length);
        return;
    }
    for (size_t i = 1; i + 1 < length; ++i)
    {
        qcReport_WriteEscaped(page, text + i, 1);
        i += text[i] == '"' && text[i + 1] == '"';
    }
}

static const char* NextRow(const char* rowEnd)
{
    return *rowEnd == 0 ? rowEnd : rowEnd + 1;
}

/// Fields are aligned like those of `model`, a row of values.
static void WriteRow(FILE* page, const char* row, const char* rowEnd, const char* model, const char* tag)
{
    if (rowEnd > row && rowEnd[-1] == '\r')
        --rowEnd;
    const char* modelEnd = FindRowEnd(model);
    fputs("<tr>", page);
    for (const char* field = row;; ++field)
    {
        const char* end = FindFieldEnd(field, rowEnd);
        const char* likeEnd = FindFieldEnd(model, modelEnd);
        fprintf(page, "<%s%s>", tag, IsNumber(model, (size_t)(likeEnd - model)) ? " class=\"n\"" : "");
        WriteField(page, field, (size_t)(end - field));
        fprintf(page, "</%s>", tag);
        model = likeEnd < modelEnd ? likeEnd + 1 : modelEnd;
        field = end;
        if (field >= rowEnd)
            break;
    }
    fputs("</tr>\n", page);
}

size_t qcReport_CountRows(const char* csv)
{
    size_t rows = 0;
    for (const char* row = NextRow(FindRowEnd(csv)); *row != 0; row = NextRow(FindRowEnd(row)))
        ++rows;
    return rows;
}

size_t qcReport_WriteCsv(FILE* page, const char* csv, size_t maxRows)
{
    size_t rows = qcReport_CountRows(csv);
    size_t every = (rows + maxRows - 1) / maxRows;
    fputs("<table>\n<thead>", page);
    const char* end = FindRowEnd(csv);
    WriteRow(page, csv, end, NextRow(end), "th");
    fputs("</thead>\n<tbody>\n", page);
    size_t number = 0;
    for (const char* row = NextRow(end); *row != 0; row = NextRow(end), ++number)
    {
        end = FindRowEnd(row);
        if (number % every == 0)
            WriteRow(page, row, end, row, "td");
    }
    fputs("</tbody>\n</table>\n", page);
    return rows;
}
