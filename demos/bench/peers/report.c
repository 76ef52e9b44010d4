// The results beside the peers: a CSV with a row a method and number of threads, and a summary for a reader.
#include "bench/peers/peers.h"

#include "common/files.h"

#include <inttypes.h>
#include <string.h>

static const char* LibraryOf(const qcPeerRow* row)
{
    return row->entrant.library != NULL ? row->entrant.library->name : "ours";
}

static double Ratio(double a, double b)
{
    return b > 0.0 ? a / b : 0.0;
}

//  ---- CSV -----------------------------------------------------------------------------------------

static void WriteRow(FILE* stream, const qcPeersTable* table, const qcPeerRow* row)
{
    static const char* const kinds[] = {"self", "deforming", "rigid"};
    fprintf(stream, "%s,%s,%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%s,", qcPeerScene_Name(table->scene), kinds[table->kind],
            table->bodyCount, table->triangleCount, row->threads, row->entrant.name);
    qcFiles_WriteQuoted(stream, LibraryOf(row));
    if (row->skipped[0] == 0)
        fprintf(stream, ",%" PRIu32 ",%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%" PRIu64 ",%d,", row->steps, row->ms, row->minMs,
                Ratio(row->ms, qcPeersTable_FindOurs(table, row->threads)->ms), row->openMs, row->firstMs,
                row->secondMs, row->pairs, row->agrees);
    else
        fputs(",,,,,,,,,,", stream);
    qcFiles_WriteQuoted(stream, row->skipped);
    fputc('\n', stream);
}

bool qcPeers_WriteCsv(const qcPeersOptions* options, const qcPeersTable* tables, uint32_t tableCount,
                      qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(options->out, "peers.csv", &output, message))
        return false;
    fputs("scene,kind,bodies,triangles,threads,method,library,steps,ms,ms_least,of_ours,open_ms,first_ms,second_ms,"
          "pairs,agrees,skipped\n",
          output.stream);
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        for (uint32_t r = 0; r < tables[t].rowCount; ++r)
            WriteRow(output.stream, &tables[t], &tables[t].rows[r]);
    }
    return qcOutput_Commit(&output, message);
}

//  ---- for a reader --------------------------------------------------------------------------------

static void PrintRow(const qcPeersTable* table, const qcPeerRow* row)
{
    const qcPeerRow* ours = qcPeersTable_FindOurs(table, row->threads);
    if (row->skipped[0] != 0)
    {
        printf("  %-16s %7" PRIu32 "  skipped: %s\n", row->entrant.name, row->threads, row->skipped);
        return;
    }
    printf("  %-16s %7" PRIu32 " %10.3f %10.3f %9.2f %9" PRIu64 "%s\n", row->entrant.name, row->threads, row->ms,
           row->minMs, Ratio(row->ms, ours->ms), row->pairs, row->agrees ? "" : "  other pairs than ours");
}

/// The summary of a number of threads.
static void PrintVerdict(const qcPeersTable* table, const qcPeerRow* ours)
{
    const qcPeerRow *embree = qcPeersTable_FindEmbree(table, ours->threads), *one = qcPeersTable_FindOurs(table, 1);
    if (embree != NULL)
        printf("  on %" PRIu32 " thread%s: Embree's best (%s) takes %.1f times as long as ours\n", ours->threads,
               ours->threads == 1 ? "" : "s", embree->entrant.name + strlen("embree-"), Ratio(embree->ms, ours->ms));
    if (one != NULL && ours->threads != 1)
        printf("  ours on %" PRIu32 " threads: %.2f times as quick as on 1\n", ours->threads, Ratio(one->ms, ours->ms));
}

static void PrintNewTopology(const qcPeersTable* table, const qcPeerRow* ours)
{
    printf("  ours, a new topology, threads %" PRIu32 ": for %s %.4f s in its first step, %.4f s in its second\n",
           ours->threads, qcPeersTable_GrowsWithPairs(table, ours) ? "1 M pairs" : "100 K triangles",
           qcPeersTable_Preprocessing(table, ours, ours->firstMs),
           qcPeersTable_Preprocessing(table, ours, ours->secondMs));
}

void qcPeers_PrintTable(const qcPeersTable* table)
{
    printf("\n%s: %s, %" PRIu32 " triangles\n", qcPeerScene_Name(table->scene), qcPeerScene_Title(table->scene),
           table->triangleCount);
    printf("  %-16s %7s %10s %10s %9s %9s\n", "", "threads", "ms median", "least", "of ours", "pairs");
    for (uint32_t i = 0; i < table->rowCount; ++i)
        PrintRow(table, &table->rows[i]);
    for (uint32_t i = 0; i < table->rowCount; ++i)
    {
        if (&table->rows[i] == qcPeersTable_FindOurs(table, table->rows[i].threads))
        {
            PrintVerdict(table, &table->rows[i]);
            PrintNewTopology(table, &table->rows[i]);
        }
    }
}
