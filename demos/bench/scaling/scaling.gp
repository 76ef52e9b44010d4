# Time and memory against size, drawn from scaling_meshes.csv and scaling_boxes.csv: gnuplot scaling.gp
meshes = 'scaling_meshes.csv'
boxes = 'scaling_boxes.csv'
set datafile separator comma
set datafile columnheaders
# Rows of other lines don't interrupt a line.
set datafile missing NaN
cairo = strstrt(GPVAL_TERMINALS, 'pngcairo') > 0 && !exists('svg')
ending = cairo ? '.png' : '.svg'
down = hasMeshes && hasBoxes ? 2 : 1
if (cairo) { set terminal pngcairo size 1300, 480 * down font 'sans,10' } \
else { set terminal svg size 1300, 480 * down font 'sans,10' background 'white' }
set output 'scaling'.ending
set logscale x
set format x '%.0s%c'
set tics out nomirror
set border 3 lc rgb '#444444'
set grid xtics ytics lt 1 lc rgb '#e4e4e4' lw 0.8
set key left top Left reverse samplen 1.5
colors = '#d7191c #1f78b4 #1b9e77 #e6ab02 #7570b3'
set multiplot layout down, 2 title 'Time and memory against size' font ',14'
isOf(t) = strcol('threads') eq t
if (hasMeshes) {
    set xlabel 'triangles of a folded cloth'
    set xrange [0.8 * minTriangles:1.25 * maxTriangles]
    set logscale y
    set ylabel 'ms a step: new vertices in, pairs out'
    set title 'a cloth with itself'
    plot for [k = 1:words(threads)] meshes using (isOf(word(threads, k)) ? column('triangles') : NaN):(column('ms')) \
        with linespoints pt 7 ps 0.8 lw 2 lc rgb word(colors, k) \
        title word(threads, k).(word(threads, k) eq '1' ? ' thread' : ' threads').' '.word(exponents, k), \
        x / 20000.0 * at20K with lines dt 2 lc rgb '#777777' title 'in proportion'
    unset logscale y
    set yrange [0:*]
    onThreads = word(threads, 1) eq '1' ? ' on one thread' : ' on '.word(threads, 1).' threads'
    set ylabel 'ns a triangle'.onThreads.'; bytes a triangle'
    set title 'a triangle of the cloth'
    set key right top
    total(k) = sum [i = 1:k] column('ms_'.word(stages, i))
    part(k) = 1e6 * total(k) / column('triangles')
    set style fill solid 0.85 noborder
    # From the top: each area covers the lower part of the one before.
    plot for [k = words(stages):1:-1] meshes using \
        (column('triangles')):(isOf(word(threads, 1)) ? part(k) : NaN) \
        with filledcurves y1=0 lc rgb word(colors, k) title word(stages, k).', ns', \
        meshes using (column('triangles')):(isOf(word(threads, 1)) ? column('bytes') : NaN) \
        with linespoints pt 5 ps 0.8 lw 2 lc rgb '#222222' title 'bytes'
    unset yrange
}
if (hasBoxes) {
    set xlabel 'boxes'
    set xrange [0.8 * minBoxes:1.25 * maxBoxes]
    set logscale y
    set format y '%g'
    set ylabel 'ms a step: boxes moved, their pairs found'
    set title 'boxes, of which a part moves'
    set key left top
    set autoscale y
    plot for [k = 1:words(percents)] boxes using \
        (column('boxes')):(strcol('percent') eq word(percents, k) ? column('ms') : NaN) \
        with linespoints pt 7 ps 0.8 lw 2 lc rgb word(colors, k) title word(percents, k).' %'
    set ylabel 'µs a box that moves'
    set title 'a box that moves'
    set yrange [0:*]
    unset logscale y
    plot for [k = 2:words(percents)] boxes using \
        (column('boxes')):(strcol('percent') eq word(percents, k) ? 1e3 * column('ms') / column('moving') : NaN) \
        with linespoints pt 7 ps 0.8 lw 2 lc rgb word(colors, k) title word(percents, k).' %'
}
unset multiplot
set output
set print '-'
print sprintf('Picture: scaling%s', ending)
