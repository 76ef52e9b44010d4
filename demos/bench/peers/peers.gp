# Ours beside peers, drawn from peers.csv beside this file: gnuplot peers.gp
# A row of bars for each number of threads; above the bars, how many times as long as ours Embree's best takes.
csv = 'peers.csv'
set datafile separator comma
set datafile columnheaders
place(s, list) = sum [k = 1:words(list)] (word(list, k) eq s ? k : 0)
isHere(t, m) = strcol('threads') eq t && strcol('method') eq word(methods, m)
hasBar(t, m) = place(word(methods, m), value('bars'.t)) > 0
count = words(methods)
width = 0.8 / count
at(m) = place(strcol('scene'), scenes) + (m - 0.5 * (count + 1)) * width

cairo = strstrt(GPVAL_TERMINALS, 'pngcairo') > 0 && !exists('svg')
ending = cairo ? '.png' : '.svg'
high = 420 * words(threads) + 40
wide = 400 + 130 * (words(scenes) > 3 ? words(scenes) : 3)
if (cairo) { set terminal pngcairo size wide, high font 'sans,11' } \
else { set terminal svg size wide, high font 'sans,11' background 'white' }
set output 'peers'.ending

set xrange [0.4:words(scenes) + 0.6]
set xtics () scale 0 rotate by 0
do for [n = 1:words(scenes)] { set xtics add (word(scenes, n)."\n".word(sizes, n) n) }
set logscale y
set format y '%g'
# The bars stand on the lower edge; the ratios need room above the highest.
low = 0.5 * minMs
set yrange [low:5 * maxMs]
set ytics out nomirror
set border 3 lc rgb '#444444'
set grid ytics lt 1 lc rgb '#e4e4e4' lw 0.8
set style fill solid 1.0 noborder
set boxwidth 0.9 * width
set key outside right top Left reverse samplen 1.5 spacing 1.2
set ylabel 'ms a step: positions in, pairs out'
set bmargin 3.5
above = strstrt(methods, 'embree') > 0 ? ". Above the bars: Embree's best, as a multiple of ours" : ''
set multiplot layout words(threads), 1 title 'Ours beside peers: median of a step'.above font ',12'
do for [t in threads] {
    set title t eq '1' ? '1 thread' : t.' threads' font ',12'
    eval value('labels'.t)
    plot for [m = 1:count] csv using (isHere(t, m) ? at(m) : NaN):(column('ms')) \
        with boxes lc rgb word(colors, m) title hasBar(t, m) ? word(methods, m) : ''
    unset label
}
unset multiplot
set output
set print '-'
print sprintf('Picture: peers%s', ending)
