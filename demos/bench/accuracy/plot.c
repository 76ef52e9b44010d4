// Draws the CSV: gnuplot does it, from a script that stays beside the CSV, so that its reader can change the picture.
#include "bench/accuracy/accuracy.h"

#include "common/files.h"
#include "common/output_file.h"

#include <inttypes.h>

static bool AnyRan(const qcAccuracyTable* tables, uint32_t tableCount)
{
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        for (uint32_t r = 0; r < tables[t].rowCount; ++r)
        {
            if (tables[t].rows[r].skipped[0] == 0)
                return true;
        }
    }
    return false;
}

static bool Occurs(const qcAccuracySeries* series, const qcAccuracyTable* tables, uint32_t tableCount)
{
    for (uint32_t t = 0; t < tableCount; ++t)
    {
        for (uint32_t r = 0; r < tables[t].rowCount; ++r)
        {
            if (tables[t].rows[r].skipped[0] == 0 && qcAccuracy_IsOf(series, &tables[t].rows[r].setting))
                return true;
        }
    }
    return false;
}

//  ---- the script ----------------------------------------------------------------------------------

static void WriteScenes(FILE* stream, const qcAccuracyOptions* options, const qcAccuracyTable* tables,
                        uint32_t tableCount)
{
    const char* which = options->margin > 0.0 ? " within the margin" : options->touching ? ", touching ones too" : "";
    uint32_t count = 0;
    for (uint32_t i = 0; i < tableCount; ++i)
        count += AnyRan(&tables[i], 1);
    fprintf(stream, "array scenes[%" PRIu32 "]\narray titles[%" PRIu32 "]\n", count, count);
    count = 0;
    for (uint32_t i = 0; i < tableCount; ++i)
    {
        // gnuplot would look in vain for the ends of the axes.
        if (!AnyRan(&tables[i], 1))
            continue;
        ++count;
        fprintf(stream,
                "scenes[%" PRIu32 "] = '%s'; titles[%" PRIu32 "] = '%s: %" PRIu32 " triangles, %" PRIu64 " pairs%s'\n",
                count, qcBenchScene_Name(tables[i].scene), count, qcBenchScene_Title(tables[i].scene),
                tables[i].triangleCount, tables[i].exact, which);
    }
    fprintf(stream, "hasAuto = %d\n", options->methods[qc_methodAuto]);
}

static void WriteSeries(FILE* stream, const qcAccuracyTable* tables, uint32_t tableCount)
{
    int count = 0;
    for (int i = 0; i < qc_accuracySeriesCount; ++i)
        count += Occurs(&qcAccuracySeries_all[i], tables, tableCount);
    int size = count > 0 ? count : 1; // gnuplot has no empty arrays
    fprintf(stream, "seriesCount = %d\narray series[%d]\narray names[%d]\narray colors[%d]\n", count, size, size, size);
    count = 0;
    for (int i = 0; i < qc_accuracySeriesCount; ++i)
    {
        const qcAccuracySetting* s = &qcAccuracySeries_all[i].setting;
        if (!Occurs(&qcAccuracySeries_all[i], tables, tableCount))
            continue;
        ++count;
        fprintf(stream, "series[%d] = '%s/%s/%s/%d'; names[%d] = '%s'; colors[%d] = 0x%06x\n", count,
                qcMethod_Name(s->method), s->backToFront ? "back-to-front" : "index",
                s->secondPassFromBack ? "back" : "front", s->reliable, count, qcAccuracySeries_all[i].title, count,
                qcAccuracySeries_all[i].color);
    }
}

static const char s_head[] = "# Run time against error, drawn from accuracy.csv beside this file: gnuplot accuracy.gp\n"
                             "# One picture a scene, and all scenes on one sheet.\n";

static const char s_body[] =
    "sceneCount = |scenes|\n"
    "csv = 'accuracy.csv'\n"
    "set datafile separator comma\n"
    "set datafile columnheaders\n"
    "\n"
    "# The row at hand: its series, 0 for auto; its place; how it is drawn.\n"
    "key(row) = strcol('method').'/'.strcol('order').'/'.strcol('second_pass').'/'.strcol('reliable')\n"
    "rank(row) = sum [k = 1:seriesCount] (key(row) eq series[k] ? k : 0)\n"
    "missed(row) = 100 * column('missed_share')\n"
    "isAuto(n) = strcol('scene') eq scenes[n] && strcol('method') eq 'auto'\n"
    "isOther(n) = strcol('scene') eq scenes[n] && strcol('method') ne 'auto'\n"
    "color(row) = rank(row) > 0 ? colors[rank(row)] : 0\n"
    "views(row) = strlen(strcol('views'))\n"
    "shape(row) = views(row) == 0 ? 2 : views(row) == 1 ? 6 : views(row) == 2 ? 4 : 8\n"
    "# From small to large images; what has none is in between.\n"
    "size(row) = column('resolution') == 0 ? 1.1 : column('resolution') < 256 ? 0.5 : \\\n"
    "    0.25 * (log(column('resolution')) / log(2) - 6)\n"
    "\n"
    "# A line comes from the row before where only the resolution differs.\n"
    "last = ''\n"
    "x0 = y0 = x1 = y1 = 0.0\n"
    "line(row) = strcol('scene').key(row).strcol('views')\n"
    "trace(row) = (joined = line(row) eq last && strcol('method') ne 'layers', last = line(row), \\\n"
    "    x0 = joined ? x1 : column('ms'), y0 = joined ? y1 : missed(row), x1 = column('ms'), y1 = missed(row), x0)\n"
    "\n"
    "# Before the axes are logarithmic: stats wants them plain.\n"
    "array autoMs[sceneCount]\n"
    "array autoMissed[sceneCount]\n"
    "array range[sceneCount]\n"
    "do for [n = 1:sceneCount] {\n"
    "    stats csv using (strcol('scene') eq scenes[n] ? column('ms') : NaN) name 'A' nooutput\n"
    "    # A single point would have an axis without ends.\n"
    "    range[n] = A_max > 2 * A_min ? 'set xrange [*:*]' : sprintf('set xrange [%g:%g]', A_min / 10, A_max * 10)\n"
    "}\n"
    "do for [n = 1:hasAuto * sceneCount] {\n"
    "    stats csv using (isAuto(n) ? column('ms') : NaN) name 'A' nooutput\n"
    "    autoMs[n] = A_mean\n"
    "    stats csv using (isAuto(n) ? missed(0) : NaN) name 'A' nooutput\n"
    "    autoMissed[n] = A_mean\n"
    "}\n"
    "\n"
    "cairo = strstrt(GPVAL_TERMINALS, 'pngcairo') > 0\n"
    "ending = cairo ? '.png' : '.svg'\n"
    "open(width, height, points) = cairo ? \\\n"
    "    sprintf(\"set terminal pngcairo size %d, %d font 'sans,%d'\", width, height, points) : \\\n"
    "    sprintf(\"set terminal svg size %d, %d font 'sans,%d' background 'white'\", width, height, points)\n"
    "\n"
    "set logscale x\n"
    "set format x '%g'\n"
    "# Zero has a place, half is near the top, and a few percent are told apart.\n"
    "set nonlinear y via asinh(y / 5.0) inverse 5.0 * sinh(y)\n"
    "set yrange [-1:130]\n"
    "set ytics (0, 1, 2, 5, 10, 20, 50, 100)\n"
    "set tics out nomirror\n"
    "set border 3 lc rgb '#444444'\n"
    "set grid xtics ytics lt 1 lc rgb '#e4e4e4' lw 0.8\n"
    "set arrow 1 from graph 0, first 50 to graph 1, first 50 nohead dt 2 lc rgb '#777777'\n"
    "set key outside right top Left reverse samplen 1.5 spacing 1.2\n"
    "\n"
    "# An iteration without values runs once, so what may be absent is left out of the command.\n"
    "autoLegend = !hasAuto ? '' : \\\n"
    "    \"NaN with points pt 13 ps 2.5 lc rgb '#d7191c' title 'auto, the default',\"\n"
    "autoRow = !hasAuto ? '' : \\\n"
    "    \", csv using (isAuto(n) ? column('ms') : NaN):(missed(0)) with points pt 13 ps 3 * scale lc rgb '#d7191c' "
    "notitle\"\n"
    "seriesLegend = seriesCount == 0 ? '' : \\\n"
    "    \"for [k = 1:seriesCount] NaN with lines lw 5 lc rgb colors[k] title names[k],\"\n"
    "legend = autoLegend.seriesLegend.\" \\\n"
    "    NaN with points pt 6 ps 1.2 lc rgb '#444444' title '1 view', \\\n"
    "    NaN with points pt 4 ps 1.2 lc rgb '#444444' title '2 views', \\\n"
    "    NaN with points pt 8 ps 1.2 lc rgb '#444444' title '3 views', \\\n"
    "    NaN with points pt 2 ps 1.2 lc rgb '#444444' title 'no image, or chosen by the planner', \\\n"
    "    NaN with points pt 6 ps 0.5 lc rgb '#444444' title '256 pixels on a side, or less', \\\n"
    "    NaN with points pt 6 ps 1.5 lc rgb '#444444' title '4096 pixels on a side'\"\n"
    "rows = \"csv using (isOther(n) ? trace(0) : NaN):(y0):(x1 - x0):(y1 - y0):(color(0)) \\\n"
    "        with vectors nohead lw 1 lc rgb variable notitle, \\\n"
    "    csv using (isOther(n) ? column('ms') : NaN):(missed(0)):(scale * size(0)):(shape(0)):(color(0)) \\\n"
    "        with points ps variable pt variable lw 1.5 lc rgb variable notitle\".autoRow\n"
    "\n"
    "eval open(1200, 720, 11)\n"
    "set xlabel 'run time, ms: new vertices in, pairs out'\n"
    "set ylabel 'pairs missed, %'\n"
    "scale = 1.0\n"
    "do for [n = 1:sceneCount] {\n"
    "    set output 'accuracy_'.scenes[n].ending\n"
    "    eval range[n]\n"
    "    set title titles[n] font ',14'\n"
    "    if (hasAuto) {\n"
    "        set arrow 2 from autoMs[n], graph 0 to autoMs[n], graph 1 nohead dt 2 lc rgb '#d7191c'\n"
    "        set label 1 sprintf('auto: %.3g ms, %.3g %% missed', autoMs[n], autoMissed[n]) \\\n"
    "            at autoMs[n], autoMissed[n] offset 1.5, 1.2 tc rgb '#d7191c'\n"
    "    }\n"
    "    plot @legend, @rows\n"
    "    unset arrow 2\n"
    "    unset label 1\n"
    "}\n"
    "\n"
    "across = ceil(sqrt(sceneCount + 1))\n"
    "down = ceil((sceneCount + 1.0) / across)\n"
    "eval open(480 * across, 380 * down, 10)\n"
    "set output 'accuracy'.ending\n"
    "set multiplot layout down, across title 'Run time against error' font ',14'\n"
    "scale = 0.8\n"
    "set xlabel 'ms'\n"
    "set ylabel 'missed, %'\n"
    "unset key\n"
    "do for [n = 1:sceneCount] {\n"
    "    eval range[n]\n"
    "    set title titles[n] font ',10'\n"
    "    if (hasAuto) { set arrow 2 from autoMs[n], graph 0 to autoMs[n], graph 1 nohead dt 2 lc rgb '#d7191c' }\n"
    "    plot @rows\n"
    "    unset arrow 2\n"
    "}\n"
    "# The last field holds the legend.\n"
    "unset arrow 1\n"
    "unset title\n"
    "unset border\n"
    "unset tics\n"
    "unset grid\n"
    "unset xlabel\n"
    "unset ylabel\n"
    "unset logscale x\n"
    "set xrange [0:1]\n"
    "set key inside center center Left reverse samplen 1.5 spacing 1.2 font ',11'\n"
    "plot @legend\n"
    "unset multiplot\n"
    "set output\n"
    "set print '-'\n"
    "print sprintf('Pictures: accuracy%s, and accuracy_SCENE%s for each scene', ending, ending)\n";

static bool WriteScript(const qcAccuracyOptions* options, const qcAccuracyTable* tables, uint32_t tableCount,
                        qcMessage* message)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/accuracy.gp", options->out);
    qcOutput output;
    if (!qcOutput_Open(path, &output, message))
        return false;
    fputs(s_head, output.stream);
    WriteScenes(output.stream, options, tables, tableCount);
    WriteSeries(output.stream, tables, tableCount);
    fputs(s_body, output.stream);
    return qcOutput_Commit(&output, message);
}

bool qcAccuracy_Plot(const qcAccuracyOptions* options, const qcAccuracyTable* tables, uint32_t tableCount,
                     qcMessage* message)
{
    if (!AnyRan(tables, tableCount))
    {
        fprintf(stderr, "nothing ran: no pictures\n");
        return true;
    }
    if (!WriteScript(options, tables, tableCount, message))
        return false;
    return qcFiles_Draw(options->out, "accuracy.gp", message);
}
