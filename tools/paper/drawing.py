"""The figures, drawn by gnuplot."""

import os
import pathlib
import subprocess
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from paper.failure import Failure

ACTIONS = ("stop", "up", "down", "left", "right", "bomb")
ACTION_COLOURS = ("#bbbbbb", "#a6cee3", "#1f78b4", "#b2df8a", "#33a02c", "#222222")


class Point(NamedTuple):
    at: float
    mean: float
    spread: float | None  # None: of one model


def block(name: str, lines: Iterable[Sequence]) -> str:
    """Data that commands call $NAME. Words are quoted."""
    text = [f"${name} << END"]
    for line in lines:
        cells = (f'"{cell}"' if isinstance(cell, str) else f"{cell:.6g}" for cell in line)
        text.append(" ".join(cells))
    return "\n".join(text + ["END", ""])


def draw(file: pathlib.Path, size: tuple[int, int], commands: str) -> None:
    part = file.with_suffix(".part")
    begin = (
        f'set terminal svg size {size[0]},{size[1]} background "white" font "sans,12"\n'
        f"set output '{part}'\nset grid lc rgb '#dddddd'\n"
    )
    try:
        done = subprocess.run(
            ["gnuplot", "-"], input=begin + commands, capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        raise Failure("no gnuplot; deploy/install installs it") from None
    if done.returncode != 0 or not part.exists():
        raise Failure(f"gnuplot cannot draw {file.name}: {done.stderr.strip()}")
    os.replace(part, file)


def bands(
    file: pathlib.Path,
    x_label: str,
    series: dict[str, list[Point]],
    published: dict[str, list[tuple[float, float]]],
) -> None:
    """Wins of each series with the spread between models; published ones dashed."""
    data = ""
    plots = []
    for number, (label, points) in enumerate(series.items(), start=1):
        ends = ((point, point.spread or 0) for point in points)
        lines = ((p.at, p.mean, p.mean - spread, p.mean + spread) for p, spread in ends)
        data += block(f"s{number}", lines)
        color = f"lc {number}"
        band = f"filledcurves fs transparent solid 0.2 {color} notitle"
        line = f'linespoints pt 7 ps 0.4 lw 2 {color} title "{label}"'
        plots += [f"$s{number} using 1:3:4 with {band}", f"$s{number} using 1:2 with {line}"]
        if label in published:
            data += block(f"p{number}", published[label])
            plots.append(f'$p{number} using 1:2 with lines dt 2 {color} title "{label}, published"')
    settings = (
        "set yrange [0:1]\nset ylabel 'games won'\nset key below\n"
        f"set xlabel '{x_label}'\nset title 'Wins, and the standard deviation between models'\n"
    )
    draw(file, (900, 560), data + settings + "plot " + ", ".join(plots) + "\n")


def action_shares(file: pathlib.Path, shares: dict[str, list[float]]) -> None:
    """A bar for each label, of the shares of ACTIONS."""
    data = block("shares", ([label, *values] for label, values in shares.items()))
    settings = (
        "set title 'What the agents do'\nset ylabel 'share of moves'\nset yrange [0:1]\n"
        "set xtics rotate by -35 nomirror\nset style data histograms\n"
        "set style histogram rowstacked\nset style fill solid 0.9 noborder\nset boxwidth 0.7\n"
        "set key outside right center vertical maxcols 1 invert reverse Left\n"
    )
    plots = ", ".join(
        f"$shares using {number + 2}:xtic(1) lc rgb '{colour}' title '{action}'"
        for number, (action, colour) in enumerate(zip(ACTIONS, ACTION_COLOURS))
    )
    draw(file, (300 + 80 * len(shares), 480), data + settings + f"plot {plots}\n")


def boards(file: pathlib.Path, maps: dict[str, list[list[float]]]) -> None:
    """How often the agents stood where, all of them started top left."""
    data = "".join(block(f"m{number}", rows) for number, rows in enumerate(maps.values()))
    most = max(max(row) for rows in maps.values() for row in rows)
    settings = (
        f"set multiplot layout 1,{len(maps)}\nunset key\nunset grid\nset size ratio -1\n"
        "set xrange [-0.5:10.5]\nset yrange [10.5:-0.5]\nset xtics 0,2,10\nset ytics 0,2,10\n"
        "set palette maxcolors 24 defined (0 '#ffffff', 0.4 '#fdae61', 1 '#7f0000')\n"
        f"set cbrange [0:{most:.6g}]\nset cblabel 'moves, %'\n"
    )
    plots = "".join(
        f"set title '{label}'\n{'' if number == 0 else 'unset colorbox'}\n"
        f"plot $m{number} matrix with image\n"
        for number, label in enumerate(maps)
    )
    draw(file, (360 * len(maps), 340), data + settings + plots + "unset multiplot\n")


def bars(file: pathlib.Path, charts: dict[str, dict[str, Point]]) -> None:
    """Charts side by side: bars by label, with the spread between models."""
    data = ""
    plots = f"set multiplot layout 1,{len(charts)}\nunset key\nset yrange [0:*]\n"
    plots += "set xtics rotate by -35 nomirror\nset style fill solid 0.6\nset boxwidth 0.6\n"
    for number, (title, points) in enumerate(charts.items()):
        found = enumerate(points.items())
        lines = ((i, label, point.mean, point.spread or 0) for i, (label, point) in found)
        data += block(f"b{number}", lines)
        plots += (
            f"set title '{title}'\nset xrange [-0.5:{len(points) - 0.5}]\n"
            f"plot $b{number} using 1:3:4:xtic(2) with boxerrorbars lc 1\n"
        )
    draw(file, (480 * len(charts), 420), data + plots + "unset multiplot\n")
