// Time and memory against size: cloths of 1 K to 4 M triangles, 100 to 200 K boxes, a share of which moves.
#include "bench/scaling/scaling.h"

#include "common/files.h"
#include "common/interrupt.h"

#include <stdio.h>
#include <stdlib.h>

static qcExitStatus Measure(const qcScalingOptions* options, qcScalingTable* table, qcMessage* message)
{
    qcInterrupt_Watch();
    // Fails here, not after minutes of work.
    if (!qcFiles_Check(options->out, "scaling_meshes.csv", message))
        return qc_exitFailed;
    for (uint32_t i = 0; i < qcScaling_CountMeshSizes(options) && qcInterrupt_Signal() == 0; ++i)
    {
        if (!qcScaling_MeasureMesh(options, i, &table->meshes[table->meshCount], message))
            return qc_exitFailed;
        table->meshCount += options->threadsCount;
    }
    for (uint32_t i = 0; i < qcScaling_CountBoxSizes(options) && qcInterrupt_Signal() == 0; ++i)
    {
        if (!qcScaling_MeasureBoxes(i, &table->boxes[table->boxCount], message))
            return qc_exitFailed;
        table->boxCount += qc_scalingFractions;
    }
    qcScaling_PrintTable(options, table);
    if (!qcScaling_WriteCsv(options, table, message))
        return qc_exitFailed;
    printf("\nAll rows: %s/scaling_meshes.csv, %s/scaling_boxes.csv\n", options->out, options->out);
    if (qcInterrupt_Signal() != 0)
        return qcInterrupt_ExitStatus();
    return qcScaling_Plot(options, table, message) ? qc_exitDone : qc_exitFailed;
}

qcExitStatus qcBench_RunScaling(int argumentCount, char** arguments)
{
    qcScalingOptions options;
    qcMessage message = {""};
    qcScaling_ReadOptions(argumentCount, arguments, &options);
    qcExitStatus ending = qc_exitFailed;
    qcScalingTable* table = calloc(1, sizeof *table);
    if (table != NULL)
        ending = Measure(&options, table, &message);
    else
        qcMessage_Fail(&message, "out of memory");
    if (ending == qc_exitFailed)
        fprintf(stderr, "qc-bench scaling: %s\n", message.text);
    free(table);
    return ending;
}
