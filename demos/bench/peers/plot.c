// The bars, drawn by gnuplot from the CSV; the script stays beside it.
#include "bench/peers/peers.h"

#include "common/files.h"
#include "peers_script.h"

#include <inttypes.h>
#include <string.h>

/// A color for each method, by its name; the methods of one library have similar colors.
static const char* ColorOf(const char* name)
{
    static const char* const colors[][2] = {{"sweep", "#d7191c"},         {"layers", "#1b9e77"},
                                            {"embree-refit", "#08519c"},  {"embree-rebuild", "#4292c6"},
                                            {"embree-medium", "#9ecae1"}, {"bullet-dbvt", "#e6ab02"},
                                            {"cgal-boxes", "#7570b3"}};
    for (size_t i = 0; i < sizeof colors / sizeof colors[0]; ++i)
    {
        if (strcmp(colors[i][0], name) == 0)
            return colors[i][1];
    }
    return "#777777";
}

static bool IsNew(const qcPeersTable* tables, uint32_t table, uint32_t row)
{
    for (uint32_t t = 0; t <= table; ++t)
    {
        for (uint32_t r = 0; r < (t == table ? row : tables[t].rowCount); ++r)
        {
            const qcPeerRow* other = &tables[t].rows[r];
            if (other->skipped[0] == 0 && strcmp(other->entrant.name, tables[table].rows[row].entrant.name) == 0)
                return false;
        }
    }
    return true;
}

static void WriteMethods(FILE* stream, const qcPeersTable* tables, uint32_t tableCount)
{
    for (int list = 0; list < 2; ++list)
    {
        fputs(list == 0 ? "methods = '" : "colors = '", stream);
        for (uint32_t t = 0; t < tableCount; ++t)
        {
            for (uint32_t r = 0; r < tables[t].rowCount; ++r)
            {
                const char* name = tables[t].rows[r].entrant.name;
                if (tables[t].rows[r].skipped[0] == 0 && IsNew(tables, t, r))
                    fprintf(stream, "%s ", list == 0 ? name : ColorOf(name));
            }
        }
        fputs("'\n", stream);
    }
}

/// For each number of threads the methods that have a bar.
static void WriteBars(FILE* stream, const qcPeersOptions* options, const qcPeersTable* tables, uint32_t tableCount)
{
    for (uint32_t i = 0; i < options->threadsCount; ++i)
    {
        fprintf(stream, "bars%" PRIu32 " = '", options->threads[i]);
        for (uint32_t t = 0; t < tableCount; ++t)
        {
            for (uint32_t r = 0; r < tables[t].rowCount; ++r)
            {
                const qcPeerRow* row = &tables[t].rows[r];
                if (row->skipped[0] == 0 && row->threads == options->threads[i])
                    fprintf(stream, "%s ", row->entrant.name);
            }
        }
        fputs("'\n", stream);
    }
}

static void WriteScenes(FILE* stream, const qcPeersTable* tables, uint32_t tableCount)
{
    fputs("scenes = '", stream);
    for (uint32_t t = 0; t < tableCount; ++t)
        fprintf(stream, "%s ", qcPeerScene_Name(tables[t].scene));
    fputs("'\nsizes = '", stream);
    for (uint32_t t = 0; t < tableCount; ++t)
        fprintf(stream, "%" PRIu32 " ", tables[t].triangleCount);
    fputs("'\n", stream);
}

/// The extreme times, and for each number of threads the ratios as labels.
static void WriteTimes(FILE* stream, const qcPeersOptions* options, const qcPeersTable* tables, uint32_t tableCount)
{
    double minMs = 1e30, maxMs = 0.0;
    fputs("threads = '", stream);
    for (uint32_t i = 0; i < options->threadsCount; ++i)
        fprintf(stream, "%" PRIu32 " ", options->threads[i]);
    fputs("'\n", stream);
    for (uint32_t i = 0; i < options->threadsCount; ++i)
    {
        uint32_t threads = options->threads[i];
        fprintf(stream, "labels%" PRIu32 " = \"", threads);
        for (uint32_t t = 0; t < tableCount; ++t)
        {
            double slowest = 0.0;
            for (uint32_t r = 0; r < tables[t].rowCount; ++r)
            {
                const qcPeerRow* row = &tables[t].rows[r];
                if (row->skipped[0] != 0)
                    continue;
                minMs = row->ms < minMs ? row->ms : minMs;
                maxMs = row->ms > maxMs ? row->ms : maxMs;
                if (row->threads == threads && row->ms > slowest)
                    slowest = row->ms;
            }
            const qcPeerRow *ours = qcPeersTable_FindOurs(&tables[t], threads),
                            *embree = qcPeersTable_FindEmbree(&tables[t], threads);
            if (embree != NULL)
                fprintf(stream, "set label '%.3g ×' at %" PRIu32 ", %g center; ", embree->ms / ours->ms, t + 1,
                        1.7 * slowest);
        }
        fputs("\"\n", stream);
    }
    fprintf(stream, "minMs = %g\nmaxMs = %g\n", minMs, maxMs);
}

bool qcPeers_Plot(const qcPeersOptions* options, const qcPeersTable* tables, uint32_t tableCount, qcMessage* message)
{
    if (tableCount == 0)
    {
        fprintf(stderr, "nothing ran: no picture\n");
        return true;
    }
    qcOutput output;
    if (!qcFiles_Open(options->out, "peers.gp", &output, message))
        return false;
    fputs("# What was measured.\n", output.stream);
    WriteScenes(output.stream, tables, tableCount);
    WriteMethods(output.stream, tables, tableCount);
    WriteBars(output.stream, options, tables, tableCount);
    WriteTimes(output.stream, options, tables, tableCount);
    fputc('\n', output.stream);
    fputs(s_peersScript, output.stream);
    return qcOutput_Commit(&output, message) && qcFiles_Draw(options->out, "peers.gp", message);
}
