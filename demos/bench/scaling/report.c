// What scaling was measured: CSVs, a summary for a reader, and a sheet of pictures drawn by gnuplot.
#include "bench/scaling/scaling.h"

#include "common/files.h"
#include "common/output_file.h"

#include <inttypes.h>
#include <math.h>

// The range that the exponent of the growth is asked for.
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
        printf("%9" PRIu32 " %7" PRIu32 " %10.3f %10.3f %9.1f", row->triangles, row->threads, row->ms, row->leastMs,
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
               row->ms, row->leastMs, row->bytes, row->addMs, row->pairs);
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
                row->steps, row->ms, row->leastMs, row->firstMs, row->secondMs, row->bytes);
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
                row->percent, row->moving, row->steps, row->ms, row->leastMs, row->addMs, row->bytes, row->pairs);
    }
}

bool qcScaling_WriteCsv(const qcScalingOptions* options, const qcScalingTable* table, qcMessage* message)
{
    for (int i = 0; i < 2; ++i)
    {
        char path[4096];
        qcOutput output;
        snprintf(path, sizeof path, "%s/scaling_%s.csv", options->out, i == 0 ? "meshes" : "boxes");
        if (!qcOutput_Open(path, &output, message))
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

//  ---- pictures ------------------------------------------------------------------------------------

static const char s_head[] =
    "# Time and memory against size, drawn from scaling_meshes.csv and scaling_boxes.csv: gnuplot scaling.gp\n";

static const char s_body[] =
    "meshes = 'scaling_meshes.csv'\n"
    "boxes = 'scaling_boxes.csv'\n"
    "set datafile separator comma\n"
    "set datafile columnheaders\n"
    "# Rows of other lines don't interrupt a line.\n"
    "set datafile missing NaN\n"
    "cairo = strstrt(GPVAL_TERMINALS, 'pngcairo') > 0\n"
    "ending = cairo ? '.png' : '.svg'\n"
    "down = hasMeshes && hasBoxes ? 2 : 1\n"
    "if (cairo) { set terminal pngcairo size 1300, 480 * down font 'sans,10' } \\\n"
    "else { set terminal svg size 1300, 480 * down font 'sans,10' background 'white' }\n"
    "set output 'scaling'.ending\n"
    "set logscale x\n"
    "set format x '%.0s%c'\n"
    "set tics out nomirror\n"
    "set border 3 lc rgb '#444444'\n"
    "set grid xtics ytics lt 1 lc rgb '#e4e4e4' lw 0.8\n"
    "set key left top Left reverse samplen 1.5\n"
    "colors = '#d7191c #1f78b4 #1b9e77 #e6ab02 #7570b3'\n"
    "set multiplot layout down, 2 title 'Time and memory against size' font ',14'\n"
    "isOf(t) = strcol('threads') eq t\n"
    "if (hasMeshes) {\n"
    "    set xlabel 'triangles of a folded cloth'\n"
    "    set xrange [0.8 * leastTriangles:1.25 * mostTriangles]\n"
    "    set logscale y\n"
    "    set ylabel 'ms a step: new vertices in, pairs out'\n"
    "    set title 'with itself'\n"
    "    plot for [k = 1:words(threads)] meshes using (isOf(word(threads, k)) ? column('triangles') : "
    "NaN):(column('ms')) "
    "\\\n"
    "        with linespoints pt 7 ps 0.8 lw 2 lc rgb word(colors, k) \\\n"
    "        title word(threads, k).(word(threads, k) eq '1' ? ' thread' : ' threads').' '.word(exponents, k), \\\n"
    "        x / 20000.0 * at20K with lines dt 2 lc rgb '#777777' title 'in proportion'\n"
    "    unset logscale y\n"
    "    set yrange [0:*]\n"
    "    set ylabel 'ns a triangle, on '.word(threads, 1).'; bytes a triangle'\n"
    "    set title 'for a triangle'\n"
    "    set key right top\n"
    "    total(k) = sum [i = 1:k] column('ms_'.word(stages, i))\n"
    "    part(k) = 1e6 * total(k) / column('triangles')\n"
    "    set style fill solid 0.85 noborder\n"
    "    # From the top: each area covers the lower part of the one before.\n"
    "    plot for [k = words(stages):1:-1] meshes using \\\n"
    "        (column('triangles')):(isOf(word(threads, 1)) ? part(k) : NaN) \\\n"
    "        with filledcurves y1=0 lc rgb word(colors, k) title word(stages, k).', ns', \\\n"
    "        meshes using (column('triangles')):(isOf(word(threads, 1)) ? column('bytes') : NaN) \\\n"
    "        with linespoints pt 5 ps 0.8 lw 2 lc rgb '#222222' title 'bytes'\n"
    "    unset yrange\n"
    "}\n"
    "if (hasBoxes) {\n"
    "    set xlabel 'boxes'\n"
    "    set xrange [0.8 * leastBoxes:1.25 * mostBoxes]\n"
    "    set logscale y\n"
    "    set format y '%g'\n"
    "    set ylabel 'ms a step: moves in, pairs of what moved out'\n"
    "    set title 'by the part that moves'\n"
    "    set key left top\n"
    "    set autoscale y\n"
    "    plot for [k = 1:words(percents)] boxes using \\\n"
    "        (column('boxes')):(strcol('percent') eq word(percents, k) ? column('ms') : NaN) \\\n"
    "        with linespoints pt 7 ps 0.8 lw 2 lc rgb word(colors, k) title word(percents, k).' %'\n"
    "    set ylabel '\302\265s a box that moves'\n"
    "    set title 'for a box that moves'\n"
    "    set yrange [0:*]\n"
    "    unset logscale y\n"
    "    plot for [k = 2:words(percents)] boxes using \\\n"
    "        (column('boxes')):(strcol('percent') eq word(percents, k) ? 1e3 * column('ms') / column('moving') : NaN) "
    "\\\n"
    "        with linespoints pt 7 ps 0.8 lw 2 lc rgb word(colors, k) title word(percents, k).' %'\n"
    "}\n"
    "unset multiplot\n"
    "set output\n"
    "set print '-'\n"
    "print sprintf('Picture: scaling%s', ending)\n";

/// What the script is told of the rows.
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
        fprintf(stream, "leastTriangles = %" PRIu32 "\nmostTriangles = %" PRIu32 "\n", table->meshes[0].triangles,
                table->meshes[table->meshCount - 1].triangles);
    if (table->boxCount != 0)
        fprintf(stream, "leastBoxes = %" PRIu32 "\nmostBoxes = %" PRIu32 "\n", table->boxes[0].boxes,
                table->boxes[table->boxCount - 1].boxes);
}

bool qcScaling_Plot(const qcScalingOptions* options, const qcScalingTable* table, qcMessage* message)
{
    if (table->meshCount + table->boxCount == 0)
    {
        fprintf(stderr, "nothing ran: no picture\n");
        return true;
    }
    char path[4096];
    snprintf(path, sizeof path, "%s/scaling.gp", options->out);
    qcOutput output;
    if (!qcOutput_Open(path, &output, message))
        return false;
    fputs(s_head, output.stream);
    WriteFacts(output.stream, options, table);
    fputs(s_body, output.stream);
    return qcOutput_Commit(&output, message) && qcFiles_Draw(options->out, "scaling.gp", message);
}
