# Long runs, drawn from stability.csv beside this file: gnuplot stability.gp
# A picture for each scene, a panel for each measure.
csv = 'stability.csv'
set datafile separator comma
set datafile columnheaders
set datafile missing NaN
cairo = strstrt(GPVAL_TERMINALS, 'pngcairo') > 0 && !exists('svg')
ending = cairo ? '.png' : '.svg'
if (cairo) { set terminal pngcairo size 760, 1000 font 'sans,10' } \
else { set terminal svg size 760, 1000 font 'sans,11' background 'white' }
set tics out nomirror
set border 3 lc rgb '#444444'
set grid xtics ytics lt 1 lc rgb '#e4e4e4' lw 0.8
set key right top samplen 1.5
set xlabel 'seconds'
set autoscale xfixmax
set xrange [0:*]
isOf(n) = strcol('scene') eq scenes[n]
of(n, name) = isOf(n) ? column(name) : NaN
red = '#d7191c'
blue = '#1f78b4'
green = '#1b9e77'
do for [n = 1:|scenes|] {
    set output 'stability_'.scenes[n].ending
    # Behind the curves: from here on the scene is at rest. Negative: the run ended before.
    unset arrow 1
    if (settled[n] >= 0) { set arrow 1 from settled[n], graph 0 to settled[n], graph 1 nohead dt 2 lc rgb '#777777' back }
    set multiplot layout 4, 2 title titles[n] font ',14'
    set yrange [*:*]
    set title 'energy, J'
    plot csv using (of(n, 'seconds')):(of(n, 'energy')) with lines lw 1.5 lc rgb blue notitle
    set title 'the same at rest, change in mJ'
    if (settled[n] >= 0) {
        plot csv using (of(n, 'seconds') >= settled[n] ? of(n, 'seconds') : NaN):(1e3 * (of(n, 'energy') - atRest[n])) \
            with lines lw 1.5 lc rgb blue notitle
    } else { set multiplot next }
    # An axis needs a value that is not zero.
    set yrange [0:*]
    set title 'deepest contact, mm'
    plot csv using (of(n, 'seconds')):(1e3 * of(n, 'depth')) with lines lw 1.5 lc rgb red notitle, \
        0.1 with dots lc rgb '#ffffffff' notitle
    set title 'pairs that penetrate'
    if (isSoft[n]) {
        plot csv using (of(n, 'seconds')):(of(n, 'pairs')) with lines lw 2 lc rgb red title 'exact test', \
            csv using (of(n, 'seconds')):(of(n, 'remaining')) with lines lw 1 dt 2 lc rgb blue title 'reported', \
            1 with dots lc rgb '#ffffffff' notitle
    } else {
        plot csv using (of(n, 'seconds')):(of(n, 'pairs')) with lines lw 2 lc rgb red title 'exact test', \
            1 with dots lc rgb '#ffffffff' notitle
    }
    set title 'contact points a step'
    plot csv using (of(n, 'seconds')):(of(n, 'contacts')) with lines lw 1.5 lc rgb green notitle, \
        1 with dots lc rgb '#ffffffff' notitle
    set title 'memory of the library, KiB'
    plot csv using (of(n, 'seconds')):(of(n, 'bytes') / 1024) with lines lw 1.5 lc rgb green notitle
    set title 'memory of the process, MiB'
    plot csv using (of(n, 'seconds')):(of(n, 'resident') / 1048576) with lines lw 1.5 lc rgb green notitle
    set title 'ms a step'
    plot csv using (of(n, 'seconds')):(of(n, 'ms')) with lines lw 1 lc rgb '#7570b3' notitle
    unset multiplot
}
set output
set print '-'
print sprintf('Pictures: stability_SCENE%s for each scene', ending)
