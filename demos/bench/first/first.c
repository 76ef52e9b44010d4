// The first answer of new bodies: every scene with each number of threads, in turns with Embree.
#include "bench/first/first.h"

#include "common/files.h"
#include "common/progress.h"

typedef struct Run
{
    qcFirstOptions options;
    const qcPeerLibrary* embree; ///< null: not built
    qcFirstRow rows[qc_peerSceneRecipes * qc_maxPeerThreads];
    uint32_t rowCount;
} Run;

static qcExitStatus MeasureScene(Run* run, int scene, qcMessage* message)
{
    const qcFirstOptions* options = &run->options;
    qcAnimation animation;
    qcProgress_Begin(0, qcPeerScene_Name(scene));
    qcBenchMade made = qcPeerScene_Make(scene, &options->models, options->steps, &animation, message);
    qcProgress_End();
    if (made == qc_benchSkipped)
    {
        printf("\n%s is skipped: %s\n", qcPeerScene_Name(scene), message->text);
        return qc_exitDone;
    }
    if (made == qc_benchFailed)
        return qc_exitBadInput;
    // On the scene that only this benchmark has, Embree's builds would take longer than all else.
    const qcPeerLibrary* embree = scene < qc_peerSceneCount ? run->embree : NULL;
    bool measured = true;
    for (uint32_t i = 0; measured && i < options->threadsCount; ++i)
    {
        qcFirstRow* row = &run->rows[run->rowCount];
        measured = qcFirst_Measure(options, &animation, embree, options->threads[i], row, message);
        if (measured)
            qcFirst_PrintRow(row, run->rowCount++ == 0);
        fflush(stdout);
    }
    qcAnimation_Free(&animation);
    return measured && qcFirst_WriteCsv(options, run->rows, run->rowCount, message) ? qc_exitDone : qc_exitFailed;
}

static qcExitStatus CheckPairs(const Run* run, qcMessage* message)
{
    for (uint32_t i = 0; i < run->rowCount; ++i)
    {
        if (run->rows[i].agrees)
            continue;
        qcMessage_Fail(message, "%s: steps find different pairs in one frame", qcPeerScene_Name(run->rows[i].scene));
        return qc_exitFailed;
    }
    return qc_exitDone;
}

static qcExitStatus Measure(Run* run, qcMessage* message)
{
    // Fails here, not after minutes of work.
    if (!qcFiles_Check(run->options.out, "first.csv", message) ||
        !qcPeerModule_Load(qc_peerEmbree, &run->embree, message))
        return qc_exitFailed;
    if (run->embree != NULL)
        printf("peer: %s\n", run->embree->name);
    else
        printf("without Embree: its package %s was not there when this was built\n",
               qcPeerModule_Packages(qc_peerEmbree));
    for (int i = 0; i < qc_peerSceneRecipes; ++i)
    {
        qcExitStatus ending = run->options.scenes[i] ? MeasureScene(run, i, message) : qc_exitDone;
        if (ending != qc_exitDone)
            return ending;
    }
    if (!qcFirst_WriteCsv(&run->options, run->rows, run->rowCount, message))
        return qc_exitFailed;
    printf("\nAll rows: %s/first.csv\n", run->options.out);
    return CheckPairs(run, message);
}

qcExitStatus qcBench_RunFirst(int argumentCount, char** arguments)
{
    static Run run;
    qcMessage message = {""};
    qcFirst_ReadOptions(argumentCount, arguments, &run.options);
    qcExitStatus ending = Measure(&run, &message);
    if (ending != qc_exitDone)
        fprintf(stderr, "qc-bench first: %s\n", message.text);
    return ending;
}
