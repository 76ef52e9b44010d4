// The parts of the report, their files, and how each is written into the page.
#ifndef QC_DEMOS_REPORT_REPORT_H
#define QC_DEMOS_REPORT_REPORT_H

#include "common/message.h"

#include <stddef.h>
#include <stdio.h>
#include <time.h>

typedef enum qcReportKind
{
    qc_reportFilm,
    qc_reportPicture,
    qc_reportText,
    qc_reportTable,
    qc_reportOther ///< not in the page
} qcReportKind;

typedef struct qcReportFile
{
    char* path;
    const char* name; ///< in `path`, without folders
    qcReportKind kind;
    time_t time; ///< of its last change
} qcReportFile;

/// A demo or benchmark, and what is there of it.
typedef struct qcReportPart
{
    char* name;
    char* command; ///< makes it; null: not a part that is known
    char* title;
    qcReportFile* files; ///< by kind, then by name
    size_t fileCount;
} qcReportPart;

typedef struct qcReport
{
    qcReportPart* parts; ///< in the order of parts.txt, then by name
    size_t partCount;
} qcReport;

/// The known parts and all files of a folder of results: FOLDER/NAME/ and FOLDER/bench/NAME.*, FOLDER/bench/NAME_*. A
/// picture stands for the same one of another format, and three stand for a series of numbered frames. False: the
/// folder can't be read.
bool qcReport_Collect(const char* folder, qcReport* report, qcMessage* message);
void qcReport_Free(qcReport* report);

/// Null, with a message: it can't be read. `size` without the zero that terminates it.
char* qcReport_ReadFile(const char* path, size_t* size, qcMessage* message);

/// Text of the page, with &, <, > and quotes escaped and other control characters left out.
void qcReport_WriteEscaped(FILE* page, const char* text, size_t length);
void qcReport_WriteText(FILE* page, const char* text);
/// "data:TYPE;base64,..." of these bytes.
void qcReport_WriteData(FILE* page, const char* type, const void* bytes, size_t size);

/// A table of a CSV: its header and at most `maxRows` rows, evenly thinned. Returns the number of rows of the CSV.
size_t qcReport_WriteCsv(FILE* page, const char* csv, size_t maxRows);
size_t qcReport_CountRows(const char* csv);

/// Rows of the table of this machine: processor, memory, GL, versions. `revision` may be null.
void qcReport_WriteMachine(FILE* page, const char* revision);

/// The whole page. `films`: a folder whose films, made small, stand for those of the same name; may be null.
bool qcReport_WritePage(FILE* page, const qcReport* report, const char* films, const char* revision,
                        qcMessage* message);

#endif
