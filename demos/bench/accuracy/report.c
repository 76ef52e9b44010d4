// The results: a CSV with a row a setting, and a summary for a reader.
#include "bench/accuracy/accuracy.h"

#include "common/files.h"

#include <inttypes.h>
#include <string.h>

double qcAccuracy_MissedShare(const qcAccuracyTable* table, const qcAccuracyRow* row)
{
    return table->exact != 0 ? (double)row->missed / (double)table->exact : 0.0;
}

//  ---- CSV -----------------------------------------------------------------------------------------

static void WriteRow(FILE* stream, const qcAccuracyOptions* options, const qcAccuracyTable* table,
                     const qcAccuracyRow* row)
{
    const qcAccuracySetting* s = &row->setting;
    bool ran = row->skipped[0] == 0;
    fprintf(stream, "%s,%" PRIu32 ",%" PRIu32 ",%.9g,%d,%s,%" PRIu64 ",", qcBenchScene_Name(table->scene),
            table->bodyCount, table->triangleCount, table->margin, options->touching, qcMethod_Name(table->reference),
            table->exact);
    fprintf(stream, "%s,%s,%" PRIu32 ",%s,%" PRIu32 ",%s,%s,%d,", qcMethod_Name(s->method),
            ran ? qcMethod_Name(row->ran) : "", s->resolution, s->views,
            qcAccuracy_IsSampled(s->method) ? options->rounds : 0, s->backToFront ? "back-to-front" : "index",
            s->secondPassFromBack ? "back" : "front", s->reliable);
    fprintf(stream, "%s,%" PRIu32 ",", table->device, table->threads);
    if (ran)
        fprintf(stream,
                "%" PRIu32 ",%" PRIu64 ",%" PRIu32 ",%.4f,%.4f,%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64
                ",%.6f,",
                row->image, row->queries, row->runs, row->ms, row->minMs, row->pcs, row->candidates, row->found,
                row->missed, row->extra, qcAccuracy_MissedShare(table, row));
    else
        fputs(",,,,,,,,,,,", stream);
    char note[sizeof row->skipped + 16];
    snprintf(note, sizeof note, "%s%s", ran ? "" : "skipped: ", ran ? row->note : row->skipped);
    qcFiles_WriteQuoted(stream, note);
    fputc('\n', stream);
}

bool qcAccuracy_WriteCsv(const qcAccuracyOptions* options, const qcAccuracyTable* tables, uint32_t tableCount,
                         qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(options->out, "accuracy.csv", &output, message))
        return false;
    fputs("scene,bodies,triangles,margin,touching,reference,exact,method,ran,resolution,views,rounds,order,"
          "second_pass,reliable,device,threads,image,queries,runs,ms,ms_least,pcs,candidates,found,missed,extra,"
          "missed_share,note\n",
          output.stream);
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        for (uint32_t r = 0; r < tables[t].rowCount; ++r)
            WriteRow(output.stream, options, &tables[t], &tables[t].rows[r]);
    }
    return qcOutput_Commit(&output, message);
}

//  ---- for a reader --------------------------------------------------------------------------------

/// Consecutive rows of one series.
typedef struct Family
{
    const char* title;
    const qcAccuracyRow* rows;
    uint32_t count, ran;
    const qcAccuracyRow *quickest, *slowest, *best, *worst; ///< of those that ran
    uint64_t minPcs, maxPcs;
} Family;

static const char* TitleOf(const qcAccuracySetting* setting)
{
    for (int i = 0; i < qc_accuracySeriesCount; ++i)
    {
        if (qcAccuracy_IsOf(&qcAccuracySeries_all[i], setting))
            return qcAccuracySeries_all[i].title;
    }
    return qcMethod_Name(setting->method);
}

static Family FindFamily(const qcAccuracyTable* table, uint32_t first)
{
    Family f = {.title = TitleOf(&table->rows[first].setting), .rows = &table->rows[first], .minPcs = UINT64_MAX};
    for (; first + f.count < table->rowCount && TitleOf(&f.rows[f.count].setting) == f.title; ++f.count)
    {
        const qcAccuracyRow* row = &f.rows[f.count];
        if (row->skipped[0] != 0)
            continue;
        ++f.ran;
        f.quickest = f.quickest == NULL || row->ms < f.quickest->ms ? row : f.quickest;
        f.slowest = f.slowest == NULL || row->ms > f.slowest->ms ? row : f.slowest;
        f.best = f.best == NULL || row->missed < f.best->missed ? row : f.best;
        f.worst = f.worst == NULL || row->missed > f.worst->missed ? row : f.worst;
        f.minPcs = row->pcs < f.minPcs ? row->pcs : f.minPcs;
        f.maxPcs = row->pcs > f.maxPcs ? row->pcs : f.maxPcs;
    }
    return f;
}

static void PrintRow(const Family* f, const qcAccuracyRow* row)
{
    char name[48];
    snprintf(name, sizeof name, "%s", f->title);
    if (row->ran != row->setting.method)
        snprintf(name, sizeof name, "%s (%s)", f->title, qcMethod_Name(row->ran));
    printf("  %-30s %10.3f %9" PRIu64 " %11" PRIu64 " %8" PRIu64 " %8" PRIu64 " %8" PRIu64 "\n", name, row->ms,
           row->pcs, row->candidates, row->found, row->missed, row->extra);
}

/// Three digits or more.
static int CountDecimals(double ms)
{
    return ms < 10.0 ? 2 : ms < 100.0 ? 1 : 0;
}

static void PrintFamily(const qcAccuracyTable* table, const Family* f)
{
    // The first row of a method that never misses has the user's default settings.
    if (f->ran != 0 && !qcAccuracy_IsSampled(f->rows[0].setting.method))
        PrintRow(f, f->rows[0].skipped[0] == 0 ? f->rows : f->quickest);
    if (f->ran > 1)
        printf("  %-30s %" PRIu32 " settings: %.*f to %.*f ms, PCS %" PRIu64 " to %" PRIu64
               ", %.1f to %.1f %% missed\n",
               f->title, f->ran, CountDecimals(f->quickest->ms), f->quickest->ms, CountDecimals(f->slowest->ms),
               f->slowest->ms, f->minPcs, f->maxPcs, 100.0 * qcAccuracy_MissedShare(table, f->best),
               100.0 * qcAccuracy_MissedShare(table, f->worst));
    else if (f->ran == 1 && qcAccuracy_IsSampled(f->rows[0].setting.method))
        PrintRow(f, f->quickest);
    if (f->ran == f->count)
        return;
    const qcAccuracyRow* skipped = f->rows;
    while (skipped->skipped[0] == 0)
        ++skipped;
    printf("  %-30s %" PRIu32 " of %" PRIu32 " settings skipped: %s\n", f->title, f->count - f->ran, f->count,
           skipped->skipped);
}

/// Compares `auto` with the sampled settings that miss less than half of the pairs: prints how many of them are slower.
static void PrintVerdict(const qcAccuracyTable* table)
{
    const qcAccuracyRow *standard = NULL, *rival = NULL;
    uint32_t sampled = 0, useful = 0, behind = 0;
    for (uint32_t i = 0; i < table->rowCount && table->rows[i].setting.method == qc_methodAuto; ++i)
        standard = &table->rows[i];
    for (uint32_t i = 0; standard != NULL && i < table->rowCount; ++i)
    {
        const qcAccuracyRow* row = &table->rows[i];
        // Without visibility queries only the sweep ran, as in `reliable` with a single body.
        if (!qcAccuracy_IsSampled(row->setting.method) || row->skipped[0] != 0 || row->queries == 0)
            continue;
        ++sampled;
        if (2 * row->missed >= table->exact && row->missed != 0)
            continue;
        ++useful;
        behind += row->ms > standard->ms;
        rival = rival == NULL || row->ms < rival->ms ? row : rival;
    }
    if (sampled == 0)
        return;
    printf("  auto misses %" PRIu64 "; %" PRIu32 " of %" PRIu32 " sampled settings miss less than half",
           standard->missed, useful, sampled);
    if (useful != 0)
        printf(", auto is quicker than %s%" PRIu32 " (than the quickest: %.3g times)", behind == useful ? "all " : "",
               behind, rival->ms / standard->ms);
    putchar('\n');
}

void qcAccuracy_PrintTable(const qcAccuracyTable* table)
{
    printf("\n%s: %s, %" PRIu32 " triangles, %" PRIu64 " pairs (%s)\n", qcBenchScene_Name(table->scene),
           qcBenchScene_Title(table->scene), table->triangleCount, table->exact, qcMethod_Name(table->reference));
    printf("  %-30s %10s %9s %11s %8s %8s %8s\n", "", "ms", "PCS", "candidates", "found", "missed", "too many");
    for (uint32_t i = 0; i < table->rowCount;)
    {
        Family family = FindFamily(table, i);
        PrintFamily(table, &family);
        i += family.count;
    }
    PrintVerdict(table);
}
