// The table and the CSV of `qc-bench first`.
#include "bench/first/first.h"

#include "common/files.h"

#include <inttypes.h>

static double Ratio(double a, double b)
{
    return b > 0.0 ? a / b : 0.0;
}

/// A dash where Embree was not built.
static void PrintEmbrees(const qcFirstRow* row, int width, double value)
{
    if (row->embreeMs > 0.0)
        printf(" %*.2f", width, value);
    else
        printf(" %*s", width, "-");
}

void qcFirst_PrintRow(const qcFirstRow* row, bool isFirst)
{
    if (isFirst)
        printf("\n%-12s %9s %2s %8s %8s %8s %8s %8s %8s %8s %8s %8s | Embree by: %6s %6s %6s\n", "ms", "triangles", "t",
               "add", "first", "second", "third", "longest", "steady", "new", "Embree", "pairs", "first", "two", "new");
    printf("%-12s %9" PRIu32 " %2" PRIu32 " %8.2f %8.2f %8.2f %8.2f %8.2f %8.3f %8.2f", qcPeerScene_Name(row->scene),
           row->triangleCount, row->threads, row->addMs, row->firstMs, row->secondMs, row->thirdMs, row->longestMs,
           row->steadyMs, row->newMs);
    PrintEmbrees(row, 8, row->embreeMs);
    printf(" %8" PRIu64 " |           ", row->pairs);
    PrintEmbrees(row, 6, Ratio(row->embreeMs, row->firstMs));
    PrintEmbrees(row, 6, Ratio(2.0 * row->embreeMs, row->firstMs + row->secondMs));
    PrintEmbrees(row, 6, Ratio(row->embreeMs, row->newMs));
    printf("%s\n", row->agrees ? "" : "  DIFFERENT PAIRS");
}

bool qcFirst_WriteCsv(const qcFirstOptions* options, const qcFirstRow* rows, uint32_t rowCount, qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(options->out, "first.csv", &output, message))
        return false;
    fputs("scene,triangles,threads,add_ms,first_ms,second_ms,third_ms,longest_ms,steady_ms,new_ms,embree_ms,"
          "embree_of_first,embree_of_two,embree_of_new,first_of_steady,pairs,agrees\n",
          output.stream);
    for (uint32_t i = 0; i < rowCount; ++i)
    {
        const qcFirstRow* r = &rows[i];
        fprintf(output.stream, "%s,%" PRIu32 ",%" PRIu32 ",%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,",
                qcPeerScene_Name(r->scene), r->triangleCount, r->threads, r->addMs, r->firstMs, r->secondMs, r->thirdMs,
                r->longestMs, r->steadyMs, r->newMs);
        if (r->embreeMs > 0.0)
            fprintf(output.stream, "%.4f,%.4f,%.4f,%.4f,", r->embreeMs, Ratio(r->embreeMs, r->firstMs),
                    Ratio(2.0 * r->embreeMs, r->firstMs + r->secondMs), Ratio(r->embreeMs, r->newMs));
        else
            fputs(",,,,", output.stream);
        fprintf(output.stream, "%.4f,%" PRIu64 ",%d\n", Ratio(r->firstMs, r->steadyMs), r->pairs, r->agrees);
    }
    return qcOutput_Commit(&output, message);
}
