// The paper's scenes, tables, figures and factors, from recordings.
#include "bench/paper/paper.h"

#include "common/device.h"
#include "common/files.h"

#include <stdlib.h>
#include <string.h>

// Tables 1 and 2 of the paper.
const qcPaperScene qcPaperScenes[qc_paperSceneCount] = {
    {"cloth", "cloth.qcr", "Cloth over a table", "qc-cloth", "cloth.qcr", 210, 1340, 21, 30, 12},
    {"cloth-without", "cloth_without.qcr", "Cloth without self-collision", "qc-cloth", "cloth.qcr", 0, 0, 0, 0, 6},
    {"breaking", "breaking.qcr", "Breaking objects", "qc-breaking", "breaking.qcr", 1400, 3600, 25, 35, 5},
    {"leaves", "leaves.qcr", "Non-rigid motion: leaves", "qc-leaves", "leaves.qcr", 450, 1200, 25, 31, 6},
};

typedef struct Run
{
    qcPaperOptions options;
    qcDevice* device;
    qcPaperTable tables[qc_paperSceneCount];
    uint32_t tableCount;
    qcPaperFactors factors;
} Run;

static qcExitStatus Prepare(Run* run, qcMessage* message)
{
    // Fails here, not after minutes of work.
    if (!qcFiles_Check(run->options.out, "paper.csv", message))
        return qc_exitFailed;
    qcDeviceDef def = qcDefaultDeviceDef();
    qcDeviceInfo info;
    def.kind = run->options.device;
    qcExitStatus status = qcToolDevice_Open(&def, &run->device, &info, message);
    if (status == qc_exitDone)
        qcToolDevice_Print(&info);
    return status;
}

/// False, with a line on standard output unless `isNamed`: the recording is missing.
static bool FindRecording(const Run* run, const qcPaperScene* scene, bool isNamed, char* path, size_t size)
{
    snprintf(path, size, "%s/%s", run->options.recordings, scene->file);
    if (qcFiles_IsThere(path))
        return true;
    if (isNamed)
        return false;
    printf("%s is skipped: there is no %s; \"%s --record %s/%s\" makes it\n", scene->name, path, scene->demo,
           run->options.recordings, scene->recordedTo);
    return false;
}

static qcExitStatus MeasureScenes(Run* run, qcMessage* message)
{
    char path[4096];
    for (int i = 0; i < qc_paperSceneCount; ++i)
    {
        if (!run->options.parts[i] || !FindRecording(run, &qcPaperScenes[i], false, path, sizeof path))
            continue;
        qcPaperRecordingInfo info;
        if (!qcPaperRecording_Inspect(path, &info, message))
            return qc_exitBadInput;
        qcPaperTable* table = &run->tables[run->tableCount++];
        if (!qcPaper_Measure(&run->options, &qcPaperScenes[i], path, &info, run->device, table, message))
            return qc_exitFailed;
        printf("%s: measured\n", qcPaperScenes[i].name);
        fflush(stdout);
        if (!qcPaper_WriteCsv(&run->options, run->tables, run->tableCount, message))
            return qc_exitFailed;
    }
    return qc_exitDone;
}

/// On a frame in which the cloth has begun to penetrate itself.
static qcExitStatus MeasureFactors(Run* run, qcMessage* message)
{
    qcDeviceInfo gl;
    char path[4096];
    // MeasureScenes names its recording where it is missing and a part by itself.
    const qcPaperScene* scene = &qcPaperScenes[1];
    if (!run->options.parts[qc_paperSceneCount] || qcDevice_GetInfo(run->device, &gl) != qc_statusOk ||
        gl.kind == qc_deviceNone || !FindRecording(run, scene, run->options.parts[1], path, sizeof path))
        return qc_exitDone;
    qcPaperRecordingInfo info;
    if (!qcPaperRecording_Inspect(path, &info, message))
        return qc_exitBadInput;
    if (!qcPaper_MeasureFactors(&run->options, scene, path, &info, run->device, &run->factors, message) ||
        !qcPaper_WriteFactorsCsv(&run->options, &run->factors, message))
        return qc_exitFailed;
    return qc_exitDone;
}

static qcExitStatus Measure(Run* run, qcMessage* message)
{
    qcExitStatus ending = Prepare(run, message);
    if (ending == qc_exitDone)
        ending = MeasureScenes(run, message);
    if (ending == qc_exitDone)
        ending = MeasureFactors(run, message);
    if (ending != qc_exitDone)
        return ending;
    if (run->tableCount == 0 && run->factors.rowCount == 0)
    {
        qcMessage_Fail(message, "no recording was found; \"demos/run.sh bench paper\" makes them");
        return qc_exitBadInput;
    }
    if (run->tableCount != 0)
        qcPaper_PrintTables(run->tables, run->tableCount);
    if (run->factors.rowCount != 0)
        qcPaper_PrintFactors(&run->factors);
    printf("\nAll rows:");
    if (run->tableCount != 0)
        printf(" %s/paper.csv", run->options.out);
    if (run->factors.rowCount != 0)
        printf(" %s/paper_factors.csv", run->options.out);
    printf("\n");
    bool drawn = qcPaper_Plot(&run->options, run->tables, run->tableCount, &run->factors, message);
    return drawn ? qc_exitDone : qc_exitFailed;
}

qcExitStatus qcBench_RunPaper(int argumentCount, char** arguments)
{
    qcMessage message = {""};
    qcExitStatus ending = qc_exitFailed;
    Run* run = calloc(1, sizeof *run);
    if (run != NULL)
    {
        qcPaper_ReadOptions(argumentCount, arguments, &run->options);
        ending = Measure(run, &message);
    }
    else
        qcMessage_Fail(&message, "out of memory");
    if (ending != qc_exitDone)
        fprintf(stderr, "qc-bench paper: %s\n", message.text);
    for (uint32_t i = 0; run != NULL && i < run->tableCount; ++i)
        qcPaperTable_Free(&run->tables[i]);
    if (run != NULL)
        qcDevice_Destroy(run->device);
    free(run);
    return ending;
}
