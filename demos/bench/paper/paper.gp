# The paper's figures 7 and 8 for each scene, and the factors of its section 5.1.3, drawn from paper.csv and
# paper_factors.csv beside this file: gnuplot paper.gp
csv = 'paper.csv'
factors = 'paper_factors.csv'
set datafile separator comma
set datafile columnheaders
# Rows of other lines don't interrupt a line.
set datafile missing NaN
cairo = strstrt(GPVAL_TERMINALS, 'pngcairo') > 0 && !exists('svg')
ending = cairo ? '.png' : '.svg'
open(width, height) = cairo ? \
    sprintf("set terminal pngcairo size %d, %d font 'sans,11'", width, height) : \
    sprintf("set terminal svg size %d, %d font 'sans,11' background 'white'", width, height)

names = 'cullide quick quick_sorted quick_sorted_back sweep layers auto embree'
labels = '"cullide" "quick" "quick, back to front" "quick, and from the back" "sweep" "layers" "auto" "Embree"'
colors = '#1f78b4 #d7191c #fdae61 #e6ab02 #222222 #1b9e77 #7570b3 #a6761d'
shapes = '5 7 9 11 1 1 1 1'
place(s) = sum [k = 1:words(names)] (word(names, k) eq s ? k : 0)
label(m) = word(labels, place(m))
color(m) = word(colors, place(m))
isSampled(m) = place(m) <= 4
style(m) = isSampled(m) ? sprintf("with linespoints pt %s ps 1.1 lw 2", word(shapes, place(m))) : 'with lines lw 1.5'

set tics out nomirror
set border 3 lc rgb '#444444'
set grid xtics ytics lt 1 lc rgb '#e4e4e4' lw 0.8
set key outside right top Left reverse samplen 1.5 spacing 1.2
isHere(n, m) = strcol('scene') eq scenes[n] && strcol('method') eq m

# Zero has a place.
sizes = "set nonlinear y via asinh(y / 2.0) inverse 2.0 * sinh(y); set yrange [0:*]; \
set ytics (0, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000, 100000)"
eval open(1150, 560)
set xrange [*:*] noextend
do for [n = 1:sceneCount] {
    set xlabel 'frame'
    set title titles[n] font ',13'
    set output 'paper_pcs_'.scenes[n].ending
    set ylabel 'triangles in the PCS'
    eval sizes
    command = 'plot '
    do for [m in methods[n]] {
        if (isSampled(m) || m eq 'sweep') {
            command = command.sprintf("csv using (isHere(%d, '%s') ? column('frame') : NaN):(column('pcs')) %s \
                lc rgb '%s' title '%s', ", n, m, style(m), color(m), label(m).(m eq 'sweep' ? ' (misses none)' : ''))
        }
    }
    paper = quickPcs[n] > 0 ? sprintf("%g with lines dt 3 lw 2 lc rgb '%s' title 'quick, mean of the paper: %g', \
        %g with lines dt 3 lw 2 lc rgb '%s' title 'cullide, mean of the paper: %g'", quickPcs[n], color('quick'), \
        quickPcs[n], cullidePcs[n], color('cullide'), cullidePcs[n]) : 'NaN notitle'
    eval command.paper
    unset nonlinear y
    set autoscale y
    set ytics auto

    set output 'paper_ms_'.scenes[n].ending
    set ylabel 'ms: positions in, pairs out'
    set logscale y
    set format y '%g'
    command = 'plot '
    do for [m in methods[n]] {
        command = command.sprintf("csv using (isHere(%d, '%s') ? column('frame') : NaN):(column('ms')) %s \
            lc rgb '%s' title '%s', ", n, m, style(m), color(m), label(m))
    }
    paper = quickMs[n] > 0 ? sprintf("%g with lines dt 3 lw 2 lc rgb '%s' title 'quick, mean of the paper: %g ms', \
        %g with lines dt 3 lw 2 lc rgb '%s' title 'cullide, mean of the paper: %g ms'", quickMs[n], color('quick'), \
        quickMs[n], cullideMs[n], color('cullide'), cullideMs[n]) : 'NaN notitle'
    eval command.paper
    unset logscale y
    set format y
}

if (hasFactors) {
    eval open(1400, 1000)
    set output 'paper_factors'.ending
    set multiplot layout 2, 2 title 'Factors of section 5.1.3: '.factorFrame font ',14'
    set style fill solid 0.9 noborder
    set key inside center top horizontal samplen 1.5
    set ylabel 'triangles in the PCS'
    eval sizes
    stats factors using (column('pcs')) name 'F' nooutput
    isOf(f, m) = strcol('factor') eq f && strcol('method') eq m
    # The number of rows of a method before the one at hand: the place of its bars.
    bar(f, m) = isOf(f, m) ? (at = at + 1, at) : NaN
    set boxwidth 0.35
    set xtics () scale 0
    do for [f in 'views order'] {
        set title f eq 'views' ? 'Number and choice of views' : 'Order of rendering, one view (z)'
        set xlabel ''
        set yrange [0:3 * F_max]
        settings = value('settings_'.f)
        set xrange [0.5:words(settings) + 0.5]
        set xtics ()
        do for [k = 1:words(settings)] { set xtics add (word(settings, k) k) }
        plot at = 0 factors using (bar(f, 'cullide') - 0.18):(column('pcs')) with boxes lc rgb color('cullide') \
                title 'cullide', \
            at = 0 factors using (bar(f, 'quick') + 0.18):(column('pcs')) with boxes lc rgb color('quick') \
                title 'quick', \
            at = 0 factors using (bar(f, 'cullide') - 0.18):(column('pcs')):(sprintf('%d', column('pcs'))) \
                with labels offset 0, 0.6 notitle, \
            at = 0 factors using (bar(f, 'quick') + 0.18):(column('pcs')):(sprintf('%d', column('pcs'))) \
                with labels offset 0, 0.6 notitle
    }
    set yrange [0:*]
    set key vertical
    set xtics auto scale 1
    set xrange [*:*]
    set title 'Depth complexity: copies of the frame one behind the other, one view (z)'
    set xlabel 'triangles over a covered point, mean'
    set ylabel 'triangles in the PCS, for each copy'
    set key inside right bottom
    plot for [m in 'cullide quick quick_sorted'] factors using \
        (isOf('depth', m) ? column('depth_complexity') : NaN):(column('pcs') / column('value')) with linespoints \
        pt 7 ps 1.2 lw 2 lc rgb color(m) title label(m)
    set title 'Resolution, two views (x and z)'
    set xlabel 'pixels on a side'
    set ylabel 'triangles; pairs'
    set logscale x 2
    set key inside left bottom
    plot for [m in 'cullide quick'] factors using \
        (isOf('resolution', m) ? column('value') : NaN):(column('pcs')) with linespoints pt 7 ps 1.2 lw 2 \
        lc rgb color(m) title label(m).': triangles in the PCS', \
        for [m in 'cullide quick'] factors using \
        (isOf('resolution', m) ? column('value') : NaN):(column('missed')) with linespoints pt 6 ps 1.2 lw 1.5 dt 2 \
        lc rgb color(m) title label(m).': pairs missed', \
        factors using (isOf('resolution', 'quick') ? column('value') : NaN):(column('exact')) with lines dt 3 lw 2 \
        lc rgb '#222222' title 'exact pairs'
    unset multiplot
}
set output
set print '-'
if (sceneCount > 0) { print sprintf('Pictures: paper_pcs_SCENE%s (figure 7), paper_ms_SCENE%s (figure 8)', ending, ending) }
if (hasFactors) { print 'Picture: paper_factors'.ending }
