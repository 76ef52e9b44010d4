// Run time against error: every setting on every scene, compared with the exact pairs.
#include "bench/accuracy/accuracy.h"

#include "common/device.h"
#include "common/files.h"
#include "common/progress.h"

#include <inttypes.h>
#include <stdlib.h>

typedef struct Run
{
    qcAccuracyOptions options;
    qcDevice* device;
    qcDeviceInfo info;
    qcAccuracyTable tables[qc_benchSceneCount];
    uint32_t tableCount;
} Run;

static qcExitStatus Prepare(Run* run, qcMessage* message)
{
    const qcAccuracyOptions* options = &run->options;
    // Fails here, not after minutes of work.
    if (!qcFiles_Check(options->out, "accuracy.csv", message))
        return qc_exitFailed;
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = options->device;
    qcExitStatus status = qcToolDevice_Open(&def, &run->device, &run->info, message);
    if (status != qc_exitDone)
        return status;
    qcToolDevice_Print(&run->info);
    qcAccuracy_WarmUp(options, run->device);
    return qc_exitDone;
}

static qcExitStatus MeasureScene(Run* run, int index, qcMessage* message)
{
    qcBenchScene scene;
    qcProgress_Begin(0, qcBenchScene_Name(index));
    qcBenchMade made = qcBenchScene_Make(index, &run->options.models, &scene, message);
    qcProgress_End();
    if (made == qc_benchSkipped)
    {
        printf("\n%s is skipped: %s\n", qcBenchScene_Name(index), message->text);
        return qc_exitDone;
    }
    if (made == qc_benchFailed)
        return qc_exitBadInput;
    qcAccuracyTable* table = &run->tables[run->tableCount++];
    *table = (qcAccuracyTable){.scene = index, .threads = run->options.threads};
    snprintf(table->device, sizeof table->device, "%s", run->info.name);
    bool measured = qcAccuracy_Measure(&run->options, &scene, run->device, table, message);
    qcBenchScene_Free(&scene);
    if (!measured)
        return qc_exitFailed;
    qcAccuracy_PrintTable(table);
    // Rows of a long run are readable while it continues, and remain if it ends early.
    fflush(stdout);
    return qcAccuracy_WriteCsv(&run->options, run->tables, run->tableCount, message) ? qc_exitDone : qc_exitFailed;
}

/// Fails if a method that never misses has missed a pair.
static qcExitStatus CheckPromise(const Run* run, qcMessage* message)
{
    for (uint32_t t = 0; t < run->tableCount; ++t)
    {
        const qcAccuracyTable* table = &run->tables[t];
        for (uint32_t r = 0; r < table->rowCount; ++r)
        {
            const qcAccuracyRow* row = &table->rows[r];
            if (row->skipped[0] != 0 ||
                (row->extra == 0 && (row->missed == 0 || qcAccuracy_IsSampled(row->setting.method))))
                continue;
            qcMessage_Fail(message, "%s: %s missed %" PRIu64 " pairs of %s and reported %" PRIu64 " that it does not",
                           qcBenchScene_Name(table->scene), qcMethod_Name(row->setting.method), row->missed,
                           qcMethod_Name(table->reference), row->extra);
            return qc_exitFailed;
        }
    }
    return qc_exitDone;
}

static qcExitStatus Measure(Run* run, qcMessage* message)
{
    qcExitStatus ending = Prepare(run, message);
    for (int i = 0; ending == qc_exitDone && i < qc_benchSceneCount; ++i)
    {
        if (run->options.scenes[i])
            ending = MeasureScene(run, i, message);
    }
    if (ending != qc_exitDone)
        return ending;
    if (!qcAccuracy_WriteCsv(&run->options, run->tables, run->tableCount, message))
        return qc_exitFailed;
    printf("\nAll rows: %s/accuracy.csv\n", run->options.out);
    if (!qcAccuracy_Plot(&run->options, run->tables, run->tableCount, message))
        return qc_exitFailed;
    return CheckPromise(run, message);
}

qcExitStatus qcBench_RunAccuracy(int argumentCount, char** arguments)
{
    Run run = {.device = NULL};
    qcMessage message = {""};
    qcAccuracy_ReadOptions(argumentCount, arguments, &run.options);
    qcExitStatus ending = Measure(&run, &message);
    if (ending != qc_exitDone)
        fprintf(stderr, "qc-bench accuracy: %s\n", message.text);
    for (uint32_t i = 0; i < run.tableCount; ++i)
        free(run.tables[i].rows);
    qcDevice_Destroy(run.device);
    return ending;
}
