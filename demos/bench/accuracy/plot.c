// The pictures, drawn by gnuplot from the CSV. The script stays beside the CSV: its reader can change the picture.
#include "bench/accuracy/accuracy.h"

#include "common/files.h"
#include "accuracy_script.h"

#include <inttypes.h>

static bool AnyRan(const qcAccuracyTable* tables, uint32_t tableCount)
{
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        for (uint32_t r = 0; r < tables[t].rowCount; ++r)
        {
            if (tables[t].rows[r].skipped[0] == 0)
                return true;
        }
    }
    return false;
}

static bool Occurs(const qcAccuracySeries* series, const qcAccuracyTable* tables, uint32_t tableCount)
{
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        for (uint32_t r = 0; r < tables[t].rowCount; ++r)
        {
            if (tables[t].rows[r].skipped[0] == 0 && qcAccuracy_IsOf(series, &tables[t].rows[r].setting))
                return true;
        }
    }
    return false;
}

static void WriteScenes(FILE* stream, const qcAccuracyOptions* options, const qcAccuracyTable* tables,
                        uint32_t tableCount)
{
    const char* which = options->margin > 0.0 ? " within the margin" : options->touching ? ", touching ones too" : "";
    uint32_t count = 0;
    for (uint32_t i = 0; i < tableCount; ++i)
        count += AnyRan(&tables[i], 1);
    fprintf(stream, "array scenes[%" PRIu32 "]\narray titles[%" PRIu32 "]\n", count, count);
    count = 0;
    for (uint32_t i = 0; i < tableCount; ++i)
    {
        // gnuplot would find no range for the axes.
        if (!AnyRan(&tables[i], 1))
            continue;
        ++count;
        fprintf(stream,
                "scenes[%" PRIu32 "] = '%s'; titles[%" PRIu32 "] = '%s: %" PRIu32 " triangles, %" PRIu64 " pairs%s'\n",
                count, qcBenchScene_Name(tables[i].scene), count, qcBenchScene_Title(tables[i].scene),
                tables[i].triangleCount, tables[i].exact, which);
    }
    fprintf(stream, "hasAuto = %d\n", options->methods[qc_methodAuto]);
}

static void WriteSeries(FILE* stream, const qcAccuracyTable* tables, uint32_t tableCount)
{
    int count = 0;
    for (int i = 0; i < qc_accuracySeriesCount; ++i)
        count += Occurs(&qcAccuracySeries_all[i], tables, tableCount);
    int size = count > 0 ? count : 1; // gnuplot has no empty arrays
    fprintf(stream, "seriesCount = %d\narray series[%d]\narray names[%d]\narray colors[%d]\n", count, size, size, size);
    count = 0;
    for (int i = 0; i < qc_accuracySeriesCount; ++i)
    {
        const qcAccuracySetting* s = &qcAccuracySeries_all[i].setting;
        if (!Occurs(&qcAccuracySeries_all[i], tables, tableCount))
            continue;
        ++count;
        fprintf(stream, "series[%d] = '%s/%s/%s/%d'; names[%d] = '%s'; colors[%d] = 0x%06x\n", count,
                qcMethod_Name(s->method), s->backToFront ? "back-to-front" : "index",
                s->secondPassFromBack ? "back" : "front", s->reliable, count, qcAccuracySeries_all[i].title, count,
                qcAccuracySeries_all[i].color);
    }
}

static bool WriteScript(const qcAccuracyOptions* options, const qcAccuracyTable* tables, uint32_t tableCount,
                        qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(options->out, "accuracy.gp", &output, message))
        return false;
    fputs("# What was measured.\n", output.stream);
    WriteScenes(output.stream, options, tables, tableCount);
    WriteSeries(output.stream, tables, tableCount);
    fputc('\n', output.stream);
    fputs(s_accuracyScript, output.stream);
    return qcOutput_Commit(&output, message);
}

bool qcAccuracy_Plot(const qcAccuracyOptions* options, const qcAccuracyTable* tables, uint32_t tableCount,
                     qcMessage* message)
{
    if (!AnyRan(tables, tableCount))
    {
        fprintf(stderr, "nothing ran: no pictures\n");
        return true;
    }
    if (!WriteScript(options, tables, tableCount, message))
        return false;
    return qcFiles_Draw(options->out, "accuracy.gp", message);
}
