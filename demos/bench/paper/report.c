// The tables for a reader, and the CSVs.
#include "bench/paper/paper.h"

#include "common/files.h"

#include <inttypes.h>

//  ---- for a reader --------------------------------------------------------------------------------

/// A number of the paper or of ours; a dash for none.
static void PrintNumber(int width, int digits, double value, bool isThere)
{
    if (isThere)
        printf(" %*.*f", width, digits, value);
    else
        printf(" %*s", width, "-");
}

static double Ratio(double a, double b)
{
    return b > 0.0 ? a / b : 0.0;
}

static void PrintSizes(const qcPaperTable* tables, uint32_t tableCount)
{
    printf("\nTable 1: average size of the potentially colliding set, triangles\n\n");
    printf("  %-30s %7s %7s %6s | %6s %7s %7s %6s %7s %9s %7s\n", "", "paper:", "", "", "", "here:", "", "", "back",
           "and from", "");
    printf("  %-30s %7s %7s %6s | %6s %7s %7s %6s %7s %9s %7s\n", "", "quick", "cullide", "ratio", "frames", "quick",
           "cullide", "ratio", "to fr.", "the back", "sweep");
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        const qcPaperTable* table = &tables[t];
        const qcPaperScene* scene = table->scene;
        qcPaperSummary quick = qcPaperTable_Summarize(table, qc_paperQuick, true);
        double cullide = qcPaperTable_Summarize(table, qc_paperCullide, true).pcs;
        bool known = scene->quickPcs > 0.0, ran = quick.frames != 0;
        printf("  %-30s", scene->title);
        PrintNumber(7, 0, scene->quickPcs, known);
        PrintNumber(7, 0, scene->cullidePcs, known);
        PrintNumber(6, 3, Ratio(scene->quickPcs, scene->cullidePcs), known);
        printf(" | %6" PRIu32, quick.frames);
        PrintNumber(7, 0, quick.pcs, ran);
        PrintNumber(7, 0, cullide, ran);
        PrintNumber(6, 3, Ratio(quick.pcs, cullide), ran && cullide > 0.0);
        PrintNumber(7, 0, qcPaperTable_Summarize(table, qc_paperQuickSorted, true).pcs, ran);
        PrintNumber(9, 0, qcPaperTable_Summarize(table, qc_paperQuickSortedBack, true).pcs, ran);
        PrintNumber(7, 0, qcPaperTable_Summarize(table, qc_paperSweep, true).pcs, ran);
        printf("\n");
    }
    printf(
        "\n  \"back to fr.\": quick, drawn back to front; \"and from the back\": with its second pass from the back, "
        "too.\n  \"sweep\": triangles in candidate pairs of sweep, which misses none.\n");
}

static void PrintTimes(const qcPaperTable* tables, uint32_t tableCount)
{
    printf("\nTable 2: average time from positions to pairs, ms\n\n");
    printf("  %-30s %7s %7s | %6s %8s %8s | %6s %8s %8s %8s %8s %7s\n", "", "paper:", "", "", "here:", "", "", "", "",
           "", "", "auto/");
    printf("  %-30s %7s %7s | %6s %8s %8s | %6s %8s %8s %8s %8s %7s\n", "", "quick", "cullide", "frames", "quick",
           "cullide", "frames", "sweep", "layers", "auto", "Embree", "better");
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        const qcPaperTable* table = &tables[t];
        const qcPaperScene* scene = table->scene;
        qcPaperSummary all[qc_paperMethodCount];
        for (int method = 0; method < qc_paperMethodCount; ++method)
            all[method] = qcPaperTable_Summarize(table, (qcPaperMethod)method, false);
        printf("  %-30s", scene->title);
        PrintNumber(7, 0, scene->quickMs, scene->quickMs > 0.0);
        PrintNumber(7, 0, scene->cullideMs, scene->quickMs > 0.0);
        printf(" | %6" PRIu32, all[qc_paperQuick].frames);
        PrintNumber(8, 1, all[qc_paperQuick].ms, all[qc_paperQuick].frames != 0);
        PrintNumber(8, 1, all[qc_paperCullide].ms, all[qc_paperCullide].frames != 0);
        printf(" | %6" PRIu32, all[qc_paperSweep].frames);
        static const qcPaperMethod exact[] = {qc_paperSweep, qc_paperLayers, qc_paperAuto, qc_paperEmbree};
        for (int i = 0; i < 4; ++i)
            PrintNumber(8, 3, all[exact[i]].ms, all[exact[i]].frames != 0);
        double better = all[qc_paperSweep].ms;
        if (all[qc_paperLayers].frames != 0 && all[qc_paperLayers].ms < better)
            better = all[qc_paperLayers].ms;
        PrintNumber(7, 2, Ratio(all[qc_paperAuto].ms, better), better > 0.0);
        printf("\n");
    }
    printf("\n  Without the first %d frames, in which methods build data. Embree: all bodies as one soup, refitted; "
           "left out "
           "where most\n  bodies have no self-collision.\n",
           qc_paperBuildingFrames);
}

static void PrintMissed(const qcPaperTable* tables, uint32_t tableCount)
{
    printf("\nPairs missed, sums over frames (not in the paper)\n\n");
    printf("  %-30s %6s %8s %8s %8s %8s %9s | %6s %9s %6s %6s %6s\n", "", "", "", "", "", "back", "and from", "", "",
           "", "", "");
    printf("  %-30s %6s %8s %8s %8s %8s %9s | %6s %9s %6s %6s %6s\n", "", "frames", "exact", "cullide", "quick",
           "to fr.", "the back", "frames", "exact", "layers", "auto", "Embree");
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        const qcPaperTable* table = &tables[t];
        qcPaperSummary sampled = qcPaperTable_Summarize(table, qc_paperQuick, true);
        qcPaperSummary all = qcPaperTable_Summarize(table, qc_paperSweep, false);
        printf("  %-30s %6" PRIu32, table->scene->title, sampled.frames);
        PrintNumber(8, 0, (double)sampled.exact, sampled.frames != 0);
        for (int method = 0; method < qc_paperSweep; ++method)
        {
            qcPaperSummary summary = qcPaperTable_Summarize(table, (qcPaperMethod)method, true);
            PrintNumber(method == qc_paperQuickSortedBack ? 9 : 8, 0, (double)summary.missed, summary.frames != 0);
        }
        printf(" | %6" PRIu32 " %9" PRIu64, all.frames, all.exact);
        for (int method = qc_paperLayers; method < qc_paperMethodCount; ++method)
        {
            qcPaperSummary summary = qcPaperTable_Summarize(table, (qcPaperMethod)method, false);
            PrintNumber(6, 0, (double)summary.missed, summary.frames != 0);
        }
        printf("\n");
    }
}

void qcPaper_PrintTables(const qcPaperTable* tables, uint32_t tableCount)
{
    printf("\n");
    if (tableCount != 0)
        printf("%s\n", tables[0].embree[0] != 0 ? tables[0].embree : "Embree: not built with it");
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        const qcPaperTable* table = &tables[t];
        printf("%s: %s%" PRIu32 " bod%s, %" PRIu32 " triangles, %" PRIu32 " frames; cullide and quick: views %s, "
               "%" PRIu32 " x %" PRIu32 " pixels, %" PRIu32 " rounds\n",
               table->scene->title, table->info.bodyCount == 1 ? "" : "up to ", table->info.bodyCount,
               table->info.bodyCount == 1 ? "y" : "ies", table->info.triangleCount, table->info.frameCount,
               table->info.views, table->resolution, table->resolution, table->iterations);
    }
    PrintSizes(tables, tableCount);
    PrintTimes(tables, tableCount);
    PrintMissed(tables, tableCount);
}

void qcPaper_PrintFactors(const qcPaperFactors* factors)
{
    printf("\nFactors (section 5.1.3), on frame %" PRIu32 " of %s\n\n", factors->frame, factors->scene->file);
    printf("  %-11s %-14s %9s %6s  %-32s %8s %9s %7s %7s\n", "factor", "", "triangles", "depth", "", "PCS", "ms",
           "exact", "missed");
    for (uint32_t i = 0; i < factors->rowCount; ++i)
    {
        const qcPaperFactorRow* row = &factors->rows[i];
        bool isNew = i == 0 || row->factor != factors->rows[i - 1].factor;
        if (isNew && i != 0)
            printf("\n");
        printf("  %-11s %-14s %9" PRIu32 " %6.2f  %-32s %8" PRIu32 " %9.1f %7" PRIu64 " %7" PRIu64 "\n",
               isNew ? row->factor : "", row->setting, row->triangles, row->depth, qcPaperMethods[row->method].label,
               row->pcs, row->ms, row->exact, row->missed);
    }
    printf(
        "\n  \"depth\": mean number of triangles over a covered point of the first view. \"order\" and \"depth\" look "
        "along z,\n  \"resolution\" along x and z.\n");
}

//  ---- CSV -----------------------------------------------------------------------------------------

bool qcPaper_WriteCsv(const qcPaperOptions* options, const qcPaperTable* tables, uint32_t tableCount,
                      qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(options->out, "paper.csv", &output, message))
        return false;
    fputs("scene,frame,method,views,resolution,rounds,pcs,ms,exact,found,missed\n", output.stream);
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        const qcPaperTable* table = &tables[t];
        for (int method = 0; method < qc_paperMethodCount; ++method)
            for (uint32_t frame = 0; frame < table->info.frameCount; ++frame)
            {
                const qcPaperCell* cell = &table->cells[method][frame];
                if (cell->ran)
                    fprintf(output.stream,
                            "%s,%" PRIu32 ",%s,%s,%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%.4f,%" PRIu64 ",%" PRIu64
                            ",%" PRIu64 "\n",
                            table->scene->name, frame, qcPaperMethods[method].column, table->info.views,
                            table->resolution, table->iterations, cell->pcs, cell->ms, table->exact[frame], cell->found,
                            cell->missed);
            }
    }
    return qcOutput_Commit(&output, message);
}

bool qcPaper_WriteFactorsCsv(const qcPaperOptions* options, const qcPaperFactors* factors, qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(options->out, "paper_factors.csv", &output, message))
        return false;
    fputs("factor,setting,value,method,triangles,depth_complexity,pcs,ms,exact,missed\n", output.stream);
    for (uint32_t i = 0; i < factors->rowCount; ++i)
    {
        const qcPaperFactorRow* row = &factors->rows[i];
        fprintf(output.stream, "%s,%s,%g,%s,%" PRIu32 ",%.3f,%" PRIu32 ",%.3f,%" PRIu64 ",%" PRIu64 "\n", row->factor,
                row->setting, row->value, qcPaperMethods[row->method].column, row->triangles, row->depth, row->pcs,
                row->ms, row->exact, row->missed);
    }
    return qcOutput_Commit(&output, message);
}
