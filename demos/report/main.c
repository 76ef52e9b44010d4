// qc-report: one page of all that the demos and benchmarks have left in their folder.
#include "report/report.h"

#include "common/exit_status.h"
#include "common/options.h"
#include "common/output_file.h"

static const char s_help[] =
    "Writes one page of HTML, with everything in it: the tables, plots, pictures and films in a folder of results, the "
    "machine and the versions. \"demos/run.sh report\" runs what is missing first.\v"
    "Exit status: 0 done; 1 the page could not be written, or a file not read; 2 a mistake on the command line.";

int main(int argumentCount, char** arguments)
{
    const char *from = "out", *page = "out/report/index.html", *films = NULL, *revision = NULL;
    const qcOption rows[] = {
        {1, "from", "FOLDER", "The results; %s by default", qcOption_Folder(&from)},
        {1, "films", "FOLDER", "Smaller films, which stand for those of the same name", qcOption_Folder(&films)},
        {1, "revision", "TEXT", "State of the sources, for the list of versions", qcOption_Text(&revision)},
        {2, "page", "FILE", "Where the page goes; %s by default", qcOption_Text(&page)},
        {0}};
    qcCommandLine line = {.options = rows, .help = s_help};
    qcCommandLine_Parse(&line, argumentCount, arguments);

    qcMessage message = {""};
    qcReport report;
    qcOutput output;
    if (!qcReport_Collect(from, &report, &message))
    {
        fprintf(stderr, "qc-report: %s\n", message.text);
        return qc_exitFailed;
    }
    bool isWritten = qcOutput_Open(page, &output, &message);
    if (isWritten)
    {
        isWritten = qcReport_WritePage(output.stream, &report, films, revision, &message);
        if (!isWritten)
            qcOutput_Abort(&output);
        else
            isWritten = qcOutput_Commit(&output, &message);
    }
    size_t missing = 0;
    for (size_t i = 0; i < report.partCount; ++i)
        missing += report.parts[i].fileCount == 0;
    if (isWritten)
        printf("%s: %zu parts, %zu missing\n", page, report.partCount, missing);
    else
        fprintf(stderr, "qc-report: %s\n", message.text);
    qcReport_Free(&report);
    return isWritten ? qc_exitDone : qc_exitFailed;
}
