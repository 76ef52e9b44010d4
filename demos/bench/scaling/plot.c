// The sheet of pictures, drawn by gnuplot from the CSVs.
#include "bench/scaling/scaling.h"

#include "common/files.h"
#include "scaling_script.h"

#include <inttypes.h>

/// Variables of the script.
static void WriteFacts(FILE* stream, const qcScalingOptions* options, const qcScalingTable* table)
{
    fprintf(stream, "hasMeshes = %d\nhasBoxes = %d\nthreads = '", table->meshCount != 0, table->boxCount != 0);
    for (uint32_t i = 0; i < options->threadsCount; ++i)
        fprintf(stream, "%" PRIu32 " ", options->threads[i]);
    fputs("'\nexponents = '", stream);
    for (uint32_t i = 0; i < options->threadsCount; ++i)
    {
        double exponent = qcScaling_FindExponent(table, options->threads[i]);
        if (exponent != 0.0)
            fprintf(stream, "(n^{%.2f}) ", exponent);
    }
    fputs("'\nstages = '", stream);
    for (int i = 0; i < qc_scalingStageCount; ++i)
        fprintf(stream, "%s ", qcScalingStage_Name((qcScalingStage)i));
    fputs("'\npercents = '0 1 10 100'\n", stream);
    double at20K = 0.0;
    for (uint32_t i = 0; i < table->meshCount && table->meshes[i].triangles <= 20000; ++i)
    {
        const qcScalingMeshRow* row = &table->meshes[i];
        if (row->threads == options->threads[0])
            at20K = row->ms * 20000.0 / row->triangles;
    }
    fprintf(stream, "at20K = %g\n", at20K);
    // Both in the order of their sizes.
    if (table->meshCount != 0)
        fprintf(stream, "minTriangles = %" PRIu32 "\nmaxTriangles = %" PRIu32 "\n", table->meshes[0].triangles,
                table->meshes[table->meshCount - 1].triangles);
    if (table->boxCount != 0)
        fprintf(stream, "minBoxes = %" PRIu32 "\nmaxBoxes = %" PRIu32 "\n", table->boxes[0].boxes,
                table->boxes[table->boxCount - 1].boxes);
}

bool qcScaling_Plot(const qcScalingOptions* options, const qcScalingTable* table, qcMessage* message)
{
    if (table->meshCount + table->boxCount == 0)
    {
        fprintf(stderr, "nothing ran: no picture\n");
        return true;
    }
    qcOutput output;
    if (!qcFiles_Open(options->out, "scaling.gp", &output, message))
        return false;
    fputs("# What was measured.\n", output.stream);
    WriteFacts(output.stream, options, table);
    fputc('\n', output.stream);
    fputs(s_scalingScript, output.stream);
    return qcOutput_Commit(&output, message) && qcFiles_Draw(options->out, "scaling.gp", message);
}
