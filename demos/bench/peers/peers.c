// Ours beside peer libraries: every method on every scene, with each number of threads, in one run.
#include "bench/peers/peers.h"

#include "common/device.h"
#include "common/files.h"
#include "common/progress.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

typedef struct Run
{
    qcPeersOptions options;
    qcDevice* device;
    qcPeerEntrant entrants[qc_maxPeerMethods];
    uint32_t entrantCount;
    qcPeersTable* tables;
    uint32_t tableCount;
} Run;

static void AddOurs(Run* run, qcMethod method)
{
    run->entrants[run->entrantCount++] = (qcPeerEntrant){qcMethod_Name(method), NULL, method, true};
}

/// Adds the libraries of --peers that are available. Prints the packages that the others need.
static qcExitStatus AddPeers(Run* run, qcMessage* message)
{
    char packages[256] = "", missing[64] = "";
    uint32_t libraryCount = 0;
    for (int i = 0; i < qc_peerLibraryCount; ++i)
    {
        const qcPeerLibrary* library;
        if (!run->options.libraries[i])
            continue;
        if (!qcPeerModule_Load(i, &library, message))
            return qc_exitFailed;
        if (library == NULL)
        {
            strcat(strcat(missing, missing[0] != 0 ? ", " : ""), qcPeerModule_Name(i));
            strcat(strcat(packages, " "), qcPeerModule_Packages(i));
            continue;
        }
        ++libraryCount;
        printf("peer: %s\n", library->name);
        for (uint32_t m = 0; m < library->methodCount; ++m)
            run->entrants[run->entrantCount++] =
                (qcPeerEntrant){library->methods[m].name, library, m, library->methods[m].threaded};
    }
    if (libraryCount != 0 && missing[0] == 0)
        return qc_exitDone;
    qcMessage_Fail(message, "not built with: %s. Install%s, or run \"demos/run.sh bench peers\", and build again",
                   missing, packages);
    if (libraryCount == 0)
        return qc_exitNoPeers;
    fprintf(stderr, "%s\n", message->text);
    return qc_exitDone;
}

static qcExitStatus AddDevice(Run* run, qcMessage* message)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    qcDeviceInfo info;
    if (run->options.device == qc_deviceNone)
        return qc_exitDone;
    def.kind = run->options.device;
    qcExitStatus status = qcToolDevice_Open(&def, &run->device, &info, message);
    if (status != qc_exitDone)
        return status;
    qcToolDevice_Print(&info);
    AddOurs(run, qc_methodLayers);
    return qc_exitDone;
}

static qcExitStatus Prepare(Run* run, qcMessage* message)
{
    run->tables = calloc(qc_peerSceneCount, sizeof *run->tables);
    if (run->tables == NULL)
    {
        qcMessage_Fail(message, "out of memory");
        return qc_exitFailed;
    }
    AddOurs(run, qc_methodSweep);
    qcExitStatus ending = AddDevice(run, message);
    if (ending == qc_exitDone)
        ending = AddPeers(run, message);
    // Fails here, not after minutes of work.
    if (ending == qc_exitDone && !qcFiles_Check(run->options.out, "peers.csv", message))
        ending = qc_exitFailed;
    return ending;
}

static qcExitStatus MeasureWork(Run* run, int index, qcMessage* message)
{
    const qcPeersOptions* options = &run->options;
    qcAnimation animation;
    qcProgress_Begin(0, qcPeerScene_Name(index));
    qcBenchMade made = qcPeerScene_Make(index, &options->models, options->frames, &animation, message);
    qcProgress_End();
    if (made == qc_benchSkipped)
    {
        printf("\n%s is skipped: %s\n", qcPeerScene_Name(index), message->text);
        return qc_exitDone;
    }
    if (made == qc_benchFailed)
        return qc_exitBadInput;
    qcPeersTable* table = &run->tables[run->tableCount++];
    *table = (qcPeersTable){.scene = index,
                            .kind = animation.kind,
                            .bodyCount = animation.bodyCount,
                            .triangleCount = animation.triangleCount};
    bool measured = true;
    for (uint32_t i = 0; measured && i < options->threadsCount; ++i)
        measured = qcPeers_Measure(options, &animation, run->entrants, run->entrantCount, run->device,
                                   options->threads[i], table, message);
    qcAnimation_Free(&animation);
    if (!measured)
        return qc_exitFailed;
    qcPeers_PrintTable(table);
    // Rows of a long run are readable while it continues, and remain if it ends early.
    fflush(stdout);
    return qcPeers_WriteCsv(options, run->tables, run->tableCount, message) ? qc_exitDone : qc_exitFailed;
}

/// All tests are exact: a method that finds other pairs than ours is wrong, or ours is.
static qcExitStatus CheckPairs(const Run* run, qcMessage* message)
{
    for (uint32_t t = 0; t < run->tableCount; ++t)
    {
        const qcPeersTable* table = &run->tables[t];
        for (uint32_t r = 0; r < table->rowCount; ++r)
        {
            const qcPeerRow* row = &table->rows[r];
            if (row->skipped[0] != 0 || row->agrees)
                continue;
            qcMessage_Fail(message,
                           "%s: %s finds other pairs than our sweep (%" PRIu64 " and %" PRIu64 " in the first frame)",
                           qcPeerScene_Name(table->scene), row->entrant.name, row->pairs,
                           qcPeersTable_FindOurs(table, row->threads)->pairs);
            return qc_exitFailed;
        }
    }
    return qc_exitDone;
}

static qcExitStatus Measure(Run* run, qcMessage* message)
{
    qcExitStatus ending = Prepare(run, message);
    for (int i = 0; ending == qc_exitDone && i < qc_peerSceneCount; ++i)
    {
        if (run->options.scenes[i])
            ending = MeasureWork(run, i, message);
    }
    if (ending != qc_exitDone)
        return ending;
    if (!qcPeers_WriteCsv(&run->options, run->tables, run->tableCount, message))
        return qc_exitFailed;
    printf("\nAll rows: %s/peers.csv\n", run->options.out);
    if (!qcPeers_Plot(&run->options, run->tables, run->tableCount, message))
        return qc_exitFailed;
    return CheckPairs(run, message);
}

qcExitStatus qcBench_RunPeers(int argumentCount, char** arguments)
{
    Run run = {.device = NULL};
    qcMessage message = {""};
    qcPeers_ReadOptions(argumentCount, arguments, &run.options);
    qcExitStatus ending = Measure(&run, &message);
    if (ending != qc_exitDone)
        fprintf(stderr, "qc-bench peers: %s\n", message.text);
    free(run.tables);
    qcDevice_Destroy(run.device);
    return ending;
}
