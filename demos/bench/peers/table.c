// What the rows of a scene say together.
#include "bench/peers/peers.h"

#include <string.h>

const qcPeerRow* qcPeersTable_FindOurs(const qcPeersTable* table, uint32_t threads)
{
    for (uint32_t i = 0; i < table->rowCount; ++i)
    {
        const qcPeerRow* row = &table->rows[i];
        if (row->threads == threads && row->entrant.library == NULL && row->entrant.method == qc_methodSweep)
            return row;
    }
    return NULL;
}

const qcPeerRow* qcPeersTable_FindEmbree(const qcPeersTable* table, uint32_t threads)
{
    const qcPeerRow* best = NULL;
    for (uint32_t i = 0; i < table->rowCount; ++i)
    {
        const qcPeerRow* row = &table->rows[i];
        if (row->threads == threads && row->skipped[0] == 0 && strncmp(row->entrant.name, "embree", 6) == 0 &&
            (best == NULL || row->ms < best->ms))
            best = row;
    }
    return best;
}

bool qcPeersTable_GrowsWithPairs(const qcPeersTable* table, const qcPeerRow* ours)
{
    return ours->pairs > table->triangleCount;
}

double qcPeersTable_Preprocessing(const qcPeersTable* table, const qcPeerRow* ours, double ms)
{
    double share = qcPeersTable_GrowsWithPairs(table, ours) ? 1e6 / (double)ours->pairs : 1e5 / table->triangleCount;
    return ms > ours->ms ? 1e-3 * (ms - ours->ms) * share : 0.0;
}
