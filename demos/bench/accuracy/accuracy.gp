# Run time against error, drawn from accuracy.csv beside this file: gnuplot accuracy.gp
# One picture a scene, and all scenes on one sheet.
sceneCount = |scenes|
csv = 'accuracy.csv'
set datafile separator comma
set datafile columnheaders

# The row at hand: its series, 0 for auto; its place; how it is drawn.
key(row) = strcol('method').'/'.strcol('order').'/'.strcol('second_pass').'/'.strcol('reliable')
rank(row) = sum [k = 1:seriesCount] (key(row) eq series[k] ? k : 0)
missed(row) = 100 * column('missed_share')
isAuto(n) = strcol('scene') eq scenes[n] && strcol('method') eq 'auto'
isOther(n) = strcol('scene') eq scenes[n] && strcol('method') ne 'auto'
color(row) = rank(row) > 0 ? colors[rank(row)] : 0
views(row) = strlen(strcol('views'))
shape(row) = views(row) == 0 ? 2 : views(row) == 1 ? 6 : views(row) == 2 ? 4 : 8
# From small to large images; what has none is in between.
size(row) = column('resolution') == 0 ? 1.1 : column('resolution') < 256 ? 0.5 : \
    0.25 * (log(column('resolution')) / log(2) - 6)

# A line comes from the row before where only the resolution differs.
last = ''
x0 = y0 = x1 = y1 = 0.0
line(row) = strcol('scene').key(row).strcol('views')
trace(row) = (joined = line(row) eq last && strcol('method') ne 'layers', last = line(row), \
    x0 = joined ? x1 : column('ms'), y0 = joined ? y1 : missed(row), x1 = column('ms'), y1 = missed(row), x0)

# Before the axes are logarithmic: stats wants them plain.
array autoMs[sceneCount]
array autoMissed[sceneCount]
array range[sceneCount]
do for [n = 1:sceneCount] {
    stats csv using (strcol('scene') eq scenes[n] ? column('ms') : NaN) name 'A' nooutput
    # A single point would have an axis without ends.
    range[n] = A_max > 2 * A_min ? 'set xrange [*:*]' : sprintf('set xrange [%g:%g]', A_min / 10, A_max * 10)
}
do for [n = 1:hasAuto * sceneCount] {
    stats csv using (isAuto(n) ? column('ms') : NaN) name 'A' nooutput
    autoMs[n] = A_mean
    stats csv using (isAuto(n) ? missed(0) : NaN) name 'A' nooutput
    autoMissed[n] = A_mean
}

cairo = strstrt(GPVAL_TERMINALS, 'pngcairo') > 0 && !exists('svg')
ending = cairo ? '.png' : '.svg'
open(width, height, points) = cairo ? \
    sprintf("set terminal pngcairo size %d, %d font 'sans,%d'", width, height, points) : \
    sprintf("set terminal svg size %d, %d font 'sans,%d' background 'white'", width, height, points)

set logscale x
set format x '%g'
# Zero has a place, half is near the top, and a few percent are told apart.
set nonlinear y via asinh(y / 5.0) inverse 5.0 * sinh(y)
set yrange [-1:130]
set ytics (0, 1, 2, 5, 10, 20, 50, 100)
set tics out nomirror
set border 3 lc rgb '#444444'
set grid xtics ytics lt 1 lc rgb '#e4e4e4' lw 0.8
set arrow 1 from graph 0, first 50 to graph 1, first 50 nohead dt 2 lc rgb '#777777'
set key outside right top Left reverse samplen 1.5 spacing 1.2

# An iteration without values runs once, so what may be absent is left out of the command.
autoLegend = !hasAuto ? '' : \
    "NaN with points pt 13 ps 2.5 lc rgb '#d7191c' title 'auto, the default',"
autoRow = !hasAuto ? '' : \
    ", csv using (isAuto(n) ? column('ms') : NaN):(missed(0)) with points pt 13 ps 3 * scale lc rgb '#d7191c' notitle"
seriesLegend = seriesCount == 0 ? '' : \
    "for [k = 1:seriesCount] NaN with lines lw 5 lc rgb colors[k] title names[k],"
legend = autoLegend.seriesLegend." \
    NaN with points pt 6 ps 1.2 lc rgb '#444444' title '1 view', \
    NaN with points pt 4 ps 1.2 lc rgb '#444444' title '2 views', \
    NaN with points pt 8 ps 1.2 lc rgb '#444444' title '3 views', \
    NaN with points pt 2 ps 1.2 lc rgb '#444444' title 'no image, or chosen by the planner', \
    NaN with points pt 6 ps 0.5 lc rgb '#444444' title '256 pixels on a side, or less', \
    NaN with points pt 6 ps 1.5 lc rgb '#444444' title '4096 pixels on a side'"
rows = "csv using (isOther(n) ? trace(0) : NaN):(y0):(x1 - x0):(y1 - y0):(color(0)) \
        with vectors nohead lw 1 lc rgb variable notitle, \
    csv using (isOther(n) ? column('ms') : NaN):(missed(0)):(scale * size(0)):(shape(0)):(color(0)) \
        with points ps variable pt variable lw 1.5 lc rgb variable notitle".autoRow

eval open(1200, 720, 11)
set xlabel 'run time, ms: new vertices in, pairs out'
set ylabel 'pairs missed, %'
scale = 1.0
do for [n = 1:sceneCount] {
    set output 'accuracy_'.scenes[n].ending
    eval range[n]
    set title titles[n] font ',14'
    if (hasAuto) {
        set arrow 2 from autoMs[n], graph 0 to autoMs[n], graph 1 nohead dt 2 lc rgb '#d7191c'
        set label 1 sprintf('auto: %.3g ms, %.3g %% missed', autoMs[n], autoMissed[n]) \
            at autoMs[n], autoMissed[n] offset 1.5, 1.2 tc rgb '#d7191c'
    }
    plot @legend, @rows
    unset arrow 2
    unset label 1
}

across = ceil(sqrt(sceneCount + 1))
down = ceil((sceneCount + 1.0) / across)
eval open(480 * across, 380 * down, 10)
set output 'accuracy'.ending
set multiplot layout down, across title 'Run time against error' font ',14'
scale = 0.8
set xlabel 'ms'
set ylabel 'missed, %'
unset key
do for [n = 1:sceneCount] {
    eval range[n]
    set title titles[n] font ',10'
    if (hasAuto) { set arrow 2 from autoMs[n], graph 0 to autoMs[n], graph 1 nohead dt 2 lc rgb '#d7191c' }
    plot @rows
    unset arrow 2
}
# The last field holds the legend.
unset arrow 1
unset title
unset border
unset tics
unset grid
unset xlabel
unset ylabel
unset logscale x
set xrange [0:1]
set key inside center center Left reverse samplen 1.5 spacing 1.2 font ',11'
plot @legend
unset multiplot
set output
set print '-'
print sprintf('Pictures: accuracy%s, and accuracy_SCENE%s for each scene', ending, ending)
