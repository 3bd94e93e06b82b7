# Draws iterations.csv; called by deploy/plot-iterations with csv, output_file and run set.
set output output_file
set datafile separator ','
set grid lc rgb '#dddddd'
set key below
set multiplot layout 2,2 title sprintf('Powderkeg, run %s', run)

set xlabel 'iteration'
set ylabel 'share of games'
set yrange [0:1]
games(w, t, l) = w + t + l
plot csv using 'iteration':'win_rate_low95':'win_rate_high95' with filledcurves \
       fc rgb '#a6cee3' fs transparent solid 0.6 title '95 % interval', \
     '' using 'iteration':'win_rate' with linespoints lc rgb '#1f78b4' lw 2 pt 7 ps 0.5 title 'won', \
     '' using 'iteration':(column('ties') / games(column('wins'), column('ties'), column('losses'))) \
       with lines lc rgb '#999999' lw 2 title 'tied', \
     '' using 'iteration':(column('losses') / games(column('wins'), column('ties'), column('losses'))) \
       with lines lc rgb '#e31a1c' lw 2 title 'lost'

set ylabel 'loss'
set yrange [*:*]
set y2label 'policy agreement'
set y2range [0:1]
set y2tics
set ytics nomirror
plot csv using 'iteration':'policy_loss' with lines lc rgb '#33a02c' lw 2 title 'policy loss', \
     '' using 'iteration':'value_loss' with lines lc rgb '#ff7f00' lw 2 title 'value loss', \
     '' using 'iteration':'policy_accuracy' axes x1y2 with lines lc rgb '#6a3d9a' dt 2 lw 2 \
       title 'agreement (right)'
unset y2tics
unset y2label
set ytics mirror

set ylabel 'share of searched moves'
set yrange [0:*]
plot csv using 'iteration':'share_stop' with lines lw 2 title 'stop', \
     '' using 'iteration':'share_up' with lines lw 2 title 'up', \
     '' using 'iteration':'share_down' with lines lw 2 title 'down', \
     '' using 'iteration':'share_left' with lines lw 2 title 'left', \
     '' using 'iteration':'share_right' with lines lw 2 title 'right', \
     '' using 'iteration':'share_bomb' with lines lw 2 lc rgb 'black' title 'bomb'

set ylabel 'steps a game'
plot csv using 'iteration':'mean_steps' with linespoints lc rgb '#b15928' lw 2 pt 7 ps 0.5 title 'mean steps'
unset multiplot
