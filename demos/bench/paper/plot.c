// Figures 7 and 8, and the factors, drawn by gnuplot from the CSVs; the script stays beside them.
#include "bench/paper/paper.h"

#include "common/files.h"
#include "paper_script.h"

#include <inttypes.h>
#include <string.h>

/// A gnuplot array of strings or numbers.
static void BeginArray(FILE* stream, const char* name, uint32_t count)
{
    fprintf(stream, "array %s[%" PRIu32 "]\n", name, count != 0 ? count : 1);
}

static void WriteScenes(FILE* stream, const qcPaperTable* tables, uint32_t tableCount)
{
    static const char* const names[] = {"scenes",  "titles",    "quickPcs", "cullidePcs",
                                        "quickMs", "cullideMs", "methods"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        BeginArray(stream, names[i], tableCount);
    fprintf(stream, "sceneCount = %" PRIu32 "\n", tableCount);
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        const qcPaperTable* table = &tables[t];
        const qcPaperScene* scene = table->scene;
        uint32_t n = t + 1;
        fprintf(stream, "scenes[%" PRIu32 "] = '%s'; titles[%" PRIu32 "] = '%s: %" PRIu32 " triangles'\n", n,
                scene->name, n, scene->title, table->info.triangleCount);
        fprintf(stream,
                "quickPcs[%" PRIu32 "] = %g; cullidePcs[%" PRIu32 "] = %g; quickMs[%" PRIu32 "] = %g; "
                "cullideMs[%" PRIu32 "] = %g\n",
                n, scene->quickPcs, n, scene->cullidePcs, n, scene->quickMs, n, scene->cullideMs);
        fprintf(stream, "methods[%" PRIu32 "] = '", n);
        for (int method = 0; method < qc_paperMethodCount; ++method)
            if (qcPaperTable_Summarize(table, (qcPaperMethod)method, false).frames != 0)
                fprintf(stream, "%s ", qcPaperMethods[method].column);
        fputs("'\n", stream);
    }
}

/// The settings of each factor, in order, for the bars.
static void WriteSettings(FILE* stream, const qcPaperFactors* factors)
{
    static const char* const names[] = {"views", "order"};
    for (int i = 0; i < 2; ++i)
    {
        fprintf(stream, "settings_%s = '", names[i]);
        for (uint32_t r = 0; r < factors->rowCount; ++r)
        {
            const qcPaperFactorRow* row = &factors->rows[r];
            if (row->method == qc_paperQuick && strcmp(row->factor, names[i]) == 0)
                fprintf(stream, "\"%s\" ", row->setting);
        }
        fputs("'\n", stream);
    }
}

bool qcPaper_Plot(const qcPaperOptions* options, const qcPaperTable* tables, uint32_t tableCount,
                  const qcPaperFactors* factors, qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(options->out, "paper.gp", &output, message))
        return false;
    fputs("# What was measured.\n", output.stream);
    WriteScenes(output.stream, tables, tableCount);
    fprintf(output.stream, "hasFactors = %d\nfactorFrame = '%s, frame %" PRIu32 "'\n", factors->rowCount != 0,
            factors->rowCount != 0 ? factors->scene->title : "", factors->frame);
    WriteSettings(output.stream, factors);
    fputc('\n', output.stream);
    fputs(s_paperScript, output.stream);
    return qcOutput_Commit(&output, message) && qcFiles_Draw(options->out, "paper.gp", message);
}
