// The page: one file without references to others.
#define _GNU_SOURCE
#include "report/report.h"

#include "common/files.h"
#include "style_script.h"

#include <stdlib.h>
#include <string.h>

enum
{
    qc_openRows = 30,    ///< a table with more is closed at first
    qc_maxRows = 150,    ///< a table with more is thinned
    qc_wideColumns = 180 ///< a text with more is printed in landscape format
};

static void WriteTime(FILE* page, time_t time)
{
    char text[64];
    struct tm local;
    strftime(text, sizeof text, "%Y-%m-%d %H:%M", localtime_r(&time, &local));
    fputs(text, page);
}

static const char* FindType(const char* name)
{
    static const char* const types[][2] = {{".mp4", "video/mp4"},
                                           {".webm", "video/webm"},
                                           {".svg", "image/svg+xml"},
                                           {".png", "image/png"},
                                           {".jpg", "image/jpeg"}};
    const char* ending = strrchr(name, '.');
    for (size_t i = 0; ending != NULL && i < sizeof types / sizeof types[0]; ++i)
    {
        if (strcasecmp(ending, types[i][0]) == 0)
            return types[i][1];
    }
    return "text/csv";
}

/// False for pictures that a killed program has left incomplete.
static bool IsComplete(const char* type, const char* bytes, size_t size)
{
    static const char signature[] = "\x89PNG\r\n\x1a\n", ending[] = "IEND\xae\x42\x60\x82";
    if (strcmp(type, "image/png") == 0)
        return size > 45 && memcmp(bytes, signature, 8) == 0 && memcmp(bytes + size - 8, ending, 8) == 0;
    if (strcmp(type, "image/svg+xml") == 0)
        return memmem(bytes, size, "<svg", 4) != NULL && memmem(bytes, size, "</svg>", 6) != NULL;
    return size != 0;
}

static void WriteMedium(FILE* page, const qcReportFile* file, const char* bytes, size_t size)
{
    const char* type = FindType(file->name);
    if (!IsComplete(type, bytes, size))
    {
        fputs("<p class=\"missing\">", page);
        qcReport_WriteText(page, file->name);
        fputs(" is not complete.</p>\n", page);
        return;
    }
    bool isFilm = file->kind == qc_reportFilm;
    fputs(isFilm ? "<figure class=\"film\"><video controls=\"controls\" loop=\"loop\" muted=\"muted\" "
                   "playsinline=\"playsinline\" preload=\"auto\" src=\""
                 : "<figure><img alt=\"",
          page);
    if (!isFilm)
    {
        qcReport_WriteText(page, file->name);
        fputs("\" src=\"", page);
    }
    qcReport_WriteData(page, type, bytes, size);
    fputs(isFilm ? "\"></video><figcaption>" : "\" /><figcaption>", page);
    qcReport_WriteText(page, file->name);
    fputs("</figcaption></figure>\n", page);
}

/// The first line of what demos/run.sh kept is "$ COMMAND"; 0: there is none.
static size_t FindCommand(const char* text)
{
    return strncmp(text, "$ ", 2) == 0 ? strcspn(text, "\n") : 0;
}

/// Characters of the longest line of UTF-8.
static size_t FindColumns(const char* text)
{
    size_t columns = 0, length = 0;
    for (; *text != 0; ++text)
    {
        length = *text == '\n' ? 0 : length + (((unsigned char)*text & 0xc0) != 0x80);
        columns = length > columns ? length : columns;
    }
    return columns;
}

static void WriteOutput(FILE* page, const char* text)
{
    text += FindCommand(text);
    text += strspn(text, "\n");
    size_t columns = FindColumns(text);
    // On paper a line is as long as the page is wide.
    fprintf(page, "<pre tabindex=\"0\"%s style=\"--columns: %zu\">", columns > qc_wideColumns ? " class=\"wide\"" : "",
            columns);
    qcReport_WriteText(page, text);
    fputs("</pre>\n", page);
}

static void WriteTable(FILE* page, const char* name, const char* csv, size_t size, bool isOpen)
{
    size_t rows = qcReport_CountRows(csv);
    fprintf(page, "<details%s><summary>", isOpen && rows <= qc_openRows ? " open=\"open\"" : "");
    qcReport_WriteText(page, name);
    fprintf(page, ": %zu %s%s", rows, rows == 1 ? "row" : "rows", rows > qc_maxRows ? ", evenly thinned here" : "");
    fputs("</summary>\n<p><a download=\"", page);
    qcReport_WriteText(page, name);
    fputs("\" href=\"", page);
    qcReport_WriteData(page, "text/csv", csv, size);
    fputs("\">The whole file</a></p>\n<div class=\"scroll\" tabindex=\"0\">\n", page);
    qcReport_WriteCsv(page, csv, qc_maxRows);
    fputs("</div></details>\n", page);
}

static bool HasText(const qcReportPart* part)
{
    for (size_t i = 0; i < part->fileCount; ++i)
    {
        if (part->files[i].kind == qc_reportText)
            return true;
    }
    return false;
}

static bool WriteFile(FILE* page, const qcReportPart* part, const qcReportFile* file, const char* films,
                      qcMessage* message)
{
    char* path = NULL;
    if (file->kind == qc_reportFilm && films != NULL && asprintf(&path, "%s/%s", films, file->name) < 0)
        return qcMessage_Fail(message, "out of memory");
    size_t size;
    char* bytes = qcReport_ReadFile(path != NULL && qcFiles_IsThere(path) ? path : file->path, &size, message);
    free(path);
    if (bytes == NULL)
        return false;
    switch (file->kind)
    {
        case qc_reportText: WriteOutput(page, bytes); break;
        case qc_reportTable: WriteTable(page, file->name, bytes, size, !HasText(part)); break;
        default: WriteMedium(page, file, bytes, size);
    }
    free(bytes);
    return true;
}

/// Plots and films stand in a grid, texts and tables below each other.
static bool WriteFiles(FILE* page, const qcReportPart* part, const char* films, qcMessage* message)
{
    bool inGrid = false;
    for (size_t i = 0; i < part->fileCount; ++i)
    {
        qcReportKind kind = part->files[i].kind;
        bool isMedium = kind == qc_reportFilm || kind == qc_reportPicture;
        if (isMedium != inGrid)
            fputs(isMedium ? "<div class=\"media\">\n" : "</div>\n", page);
        inGrid = isMedium;
        if (!WriteFile(page, part, &part->files[i], films, message))
            return false;
    }
    if (inGrid)
        fputs("</div>\n", page);
    return true;
}

/// When the part ran: plots may have been drawn again later.
static time_t FindTime(const qcReportPart* part)
{
    time_t newest = 0;
    for (size_t i = 0; i < part->fileCount; ++i)
    {
        const qcReportFile* file = &part->files[i];
        bool counts = file->kind == qc_reportText || !HasText(part);
        newest = counts && file->time > newest ? file->time : newest;
    }
    return newest;
}

/// The commands of the part's texts, above everything else.
static bool WriteCommands(FILE* page, const qcReportPart* part, qcMessage* message)
{
    for (size_t i = 0; i < part->fileCount; ++i)
    {
        if (part->files[i].kind != qc_reportText)
            continue;
        size_t size;
        char* text = qcReport_ReadFile(part->files[i].path, &size, message);
        if (text == NULL)
            return false;
        size_t length = FindCommand(text);
        if (length != 0)
        {
            fputs("<p class=\"command\"><code>", page);
            qcReport_WriteEscaped(page, text + 2, length - 2);
            fputs("</code></p>\n", page);
        }
        free(text);
    }
    return true;
}

static bool WritePart(FILE* page, const qcReportPart* part, const char* films, qcMessage* message)
{
    fputs("<section id=\"", page);
    qcReport_WriteText(page, part->name);
    fputs("\">\n<h2>", page);
    qcReport_WriteText(page, part->title != NULL ? part->title : part->name);
    fputs("</h2>\n", page);
    if (part->fileCount == 0)
    {
        fputs("<p class=\"missing\">Nothing is there. This makes it: <code>demos/run.sh ", page);
        qcReport_WriteText(page, part->command);
        fputs("</code></p>\n", page);
    }
    else
    {
        fputs("<p class=\"time\">", page);
        WriteTime(page, FindTime(part));
        fputs("</p>\n", page);
    }
    bool isWritten = WriteCommands(page, part, message) && WriteFiles(page, part, films, message);
    fputs("</section>\n", page);
    return isWritten;
}

static void WriteContents(FILE* page, const qcReport* report)
{
    fputs("<nav><ul>\n<li><a href=\"#machine\">Machine and versions</a></li>\n", page);
    for (size_t i = 0; i < report->partCount; ++i)
    {
        const qcReportPart* part = &report->parts[i];
        fputs("<li><a href=\"#", page);
        qcReport_WriteText(page, part->name);
        fputs("\">", page);
        qcReport_WriteText(page, part->title != NULL ? part->title : part->name);
        fputs(part->fileCount != 0 ? "</a></li>\n" : "</a> (missing)</li>\n", page);
    }
    fputs("</ul></nav>\n", page);
}

bool qcReport_WritePage(FILE* page, const qcReport* report, const char* films, const char* revision, qcMessage* message)
{
    // XHTML: every reader of XML can check it.
    fputs("<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n"
          "<meta charset=\"utf-8\" />\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\" />\n"
          "<title>Quick-CULLIDE: report</title>\n<style>\n",
          page);
    fputs(s_styleScript, page);
    fputs("</style>\n</head>\n<body>\n<header><h1>Quick-CULLIDE for Bullet: report</h1>\n<p>", page);
    WriteTime(page, time(NULL));
    fputs("</p></header>\n", page);
    WriteContents(page, report);
    fputs("<section id=\"machine\">\n<h2>Machine and versions</h2>\n<div class=\"scroll\"><table class=\"facts\">\n",
          page);
    qcReport_WriteMachine(page, revision);
    fputs("</table></div>\n<p>These hold for the moment at which this page was made. Each part has its own time.</p>\n"
          "</section>\n",
          page);
    bool isWritten = true;
    for (size_t i = 0; i < report->partCount && isWritten; ++i)
        isWritten = WritePart(page, &report->parts[i], films, message);
    fputs("</body>\n</html>\n", page);
    return isWritten;
}
