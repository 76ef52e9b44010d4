// The results: CSVs, and a readable summary.
#include "bench/scaling/scaling.h"

#include "common/files.h"

#include <inttypes.h>
#include <math.h>

// The range of sizes for the exponent of the growth.
static const double s_lowest = 19000.0, s_highest = 1050000.0;

static const char* const s_stageNames[qc_scalingStageCount] = {"vertices", "objects", "triangles", "exact", "other"};

const char* qcScalingStage_Name(qcScalingStage stage)
{
    return s_stageNames[stage];
}

/// The slope of a straight line through the logarithms of ms against those of the size, least squares.
typedef struct Line
{
    double n, x, y, xx, xy;
} Line;

static void Take(Line* line, double size, double ms)
{
    double x = log(size), y = log(ms);
    line->n += 1.0;
    line->x += x;
    line->y += y;
    line->xx += x * x;
    line->xy += x * y;
}

static double Slope(const Line* line)
{
    double spread = line->n * line->xx - line->x * line->x;
    return line->n >= 2.0 && spread > 0.0 ? (line->n * line->xy - line->x * line->y) / spread : 0.0;
}

double qcScaling_FindExponent(const qcScalingTable* table, uint32_t threads)
{
    Line line = {0.0, 0.0, 0.0, 0.0, 0.0};
    for (uint32_t i = 0; i < table->meshCount; ++i)
    {
        const qcScalingMeshRow* row = &table->meshes[i];
        if (row->threads == threads && row->triangles > s_lowest && row->triangles < s_highest)
            Take(&line, row->triangles, row->ms);
    }
    return Slope(&line);
}

//  ---- for a reader --------------------------------------------------------------------------------

static void PrintMeshes(const qcScalingOptions* options, const qcScalingTable* table)
{
    printf("\n%9s %7s %10s %10s %9s", "triangles", "threads", "ms median", "least", "bytes");
    for (int i = 0; i < qc_scalingStageCount; ++i)
        printf(" %9s", qcScalingStage_Name((qcScalingStage)i));
    printf(" %8s\n", "pairs");
    for (uint32_t i = 0; i < table->meshCount; ++i)
    {
        const qcScalingMeshRow* row = &table->meshes[i];
        printf("%9" PRIu32 " %7" PRIu32 " %10.3f %10.3f %9.1f", row->triangles, row->threads, row->ms, row->minMs,
               row->bytes);
        for (int k = 0; k < qc_scalingStageCount; ++k)
            printf(" %9.3f", row->stages[k]);
        printf(" %8" PRIu64 "\n", row->pairs);
    }
    for (uint32_t i = 0; i < options->threadsCount; ++i)
    {
        double exponent = qcScaling_FindExponent(table, options->threads[i]);
        if (exponent != 0.0)
            printf("growth from 20 K to 1 M triangles, threads %" PRIu32 ": n^%.2f\n", options->threads[i], exponent);
    }
}

static void PrintBoxes(const qcScalingTable* table)
{
    printf("\n%9s %7s %10s %10s %9s %10s %8s\n", "boxes", "moving", "ms median", "least", "bytes", "ms to add",
           "pairs");
    for (uint32_t i = 0; i < table->boxCount; ++i)
    {
        const qcScalingBoxRow* row = &table->boxes[i];
        printf("%9" PRIu32 " %5" PRIu32 " %% %10.4f %10.4f %9.1f %10.3f %8" PRIu64 "\n", row->boxes, row->percent,
               row->ms, row->minMs, row->bytes, row->addMs, row->pairs);
    }
}

void qcScaling_PrintTable(const qcScalingOptions* options, const qcScalingTable* table)
{
    if (table->meshCount != 0)
        PrintMeshes(options, table);
    if (table->boxCount != 0)
        PrintBoxes(table);
}

//  ---- CSV -----------------------------------------------------------------------------------------

static void WriteMeshes(FILE* stream, const qcScalingTable* table)
{
    fputs("triangles,threads,steps,ms,ms_least,first_ms,second_ms,bytes", stream);
    for (int i = 0; i < qc_scalingStageCount; ++i)
        fprintf(stream, ",ms_%s", qcScalingStage_Name((qcScalingStage)i));
    fputs(",candidates,pairs\n", stream);
    for (uint32_t i = 0; i < table->meshCount; ++i)
    {
        const qcScalingMeshRow* row = &table->meshes[i];
        fprintf(stream, "%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%.4f,%.4f,%.4f,%.4f,%.2f", row->triangles, row->threads,
                row->steps, row->ms, row->minMs, row->firstMs, row->secondMs, row->bytes);
        for (int k = 0; k < qc_scalingStageCount; ++k)
            fprintf(stream, ",%.4f", row->stages[k]);
        fprintf(stream, ",%" PRIu64 ",%" PRIu64 "\n", row->candidates, row->pairs);
    }
}

static void WriteBoxes(FILE* stream, const qcScalingTable* table)
{
    fputs("boxes,percent,moving,steps,ms,ms_least,add_ms,bytes,pairs\n", stream);
    for (uint32_t i = 0; i < table->boxCount; ++i)
    {
        const qcScalingBoxRow* row = &table->boxes[i];
        fprintf(stream, "%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%.5f,%.5f,%.4f,%.2f,%" PRIu64 "\n", row->boxes,
                row->percent, row->moving, row->steps, row->ms, row->minMs, row->addMs, row->bytes, row->pairs);
    }
}

bool qcScaling_WriteCsv(const qcScalingOptions* options, const qcScalingTable* table, qcMessage* message)
{
    for (int i = 0; i < 2; ++i)
    {
        qcOutput output;
        if (!qcFiles_Open(options->out, i == 0 ? "scaling_meshes.csv" : "scaling_boxes.csv", &output, message))
            return false;
        if (i == 0)
            WriteMeshes(output.stream, table);
        else
            WriteBoxes(output.stream, table);
        if (!qcOutput_Commit(&output, message))
            return false;
    }
    return true;
}
