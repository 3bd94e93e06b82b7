# Draws the figures of an arena table; called by deploy/plot-arena with data (a folder of what it
# took out of the table), name, extension and terminal_type set.
lines(file) = int(system(sprintf("wc -l < '%s/%s'", data, file)))
line(file, n) = system(sprintf("sed -n %dp '%s/%s'", n, data, file))
first(text) = word(text, 1)
rest(text) = substr(text, strlen(first(text)) + 2, strlen(text))
agents = lines('agents')
set grid lc rgb '#dddddd'

# Win rate over simulations.
eval sprintf("set terminal %s size 900,600", terminal_type)
set output sprintf('%s-win-rate.%s', name, extension)
set title 'Win rate with 95 % intervals'
set xlabel 'simulations per move'
set ylabel 'games won'
set yrange [0:1]
set logscale x 2
set key below left maxcols 1 noenhanced
series = lines('series')
levels = lines('levels')
if (series == 0) { set xrange [1:1024] }
points = "plot"
do for [i=1:series] {
  points = points . sprintf(" '%s/series-%s' using 1:2:3:4 with yerrorlines lw 2 pt 7 ps 0.7 title '%s',", data, first(line('series', i)), rest(line('series', i)))
}
do for [i=1:levels] {
  points = points . sprintf(" %s with lines dt 2 lw 2 title '%s',", first(line('levels', i)), rest(line('levels', i)))
}
eval points[1:strlen(points) - 1]
unset logscale x

# Action shares.
eval sprintf("set terminal %s size %d,600", terminal_type, 500 + 60 * agents)
set output sprintf('%s-actions.%s', name, extension)
set title 'What the agents do'
set xlabel ''
set ylabel 'share of moves'
set xrange [-0.5:agents - 0.5]
set xtics rotate by -35 noenhanced nomirror
unset key
set key outside right center vertical maxcols 1 invert reverse Left
set style data histograms
set style histogram rowstacked
set style fill solid 0.9 noborder
set boxwidth 0.7
array actions[6] = ['stop', 'up', 'down', 'left', 'right', 'bomb']
array colours[6] = ['#bbbbbb', '#a6cee3', '#1f78b4', '#b2df8a', '#33a02c', '#222222']
plot for [i=1:6] data.'/actions' using i+1:xtic(1) lc rgb colours[i] title actions[i]

# Heat maps.
columns = agents < 4 ? agents : int(ceil(sqrt(agents)))
rows = int(ceil(1.0 * agents / columns))
eval sprintf("set terminal %s size %d,%d", terminal_type, 420 * columns, 400 * rows)
set output sprintf('%s-board.%s', name, extension)
set multiplot layout rows,columns
unset key
unset grid
unset xlabel
unset ylabel
set size ratio -1
set xrange [-0.5:10.5]
set yrange [10.5:-0.5]
set xtics 0,2,10 norotate
set ytics 0,2,10
set palette defined (0 '#ffffff', 0.4 '#fdae61', 1 '#7f0000')
set cbrange [0:*]
set cblabel 'moves, %'
do for [i=1:agents] {
  set title line('agents', i) noenhanced font ',9'
  plot sprintf('%s/board-%d', data, i - 1) matrix with image
}
unset multiplot
