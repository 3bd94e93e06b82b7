"""Counts the games of each kind in a replay folder: stored_kinds.py FOLDER prints those in which
four seats learned, those with weights of two versions, and those of teams, in one line."""

import pathlib
import sys

import h5py

four = two = team = 0
for path in sorted(pathlib.Path(sys.argv[1]).glob("segment-*.h5")):
    with h5py.File(path) as segment:
        games = segment["games"]
        four += int((games["decision_count"][:] > 0).all(axis=1).sum())
        two += sum(len(set(row) - {0}) > 1 for row in games["weights_version"][:].tolist())
        team += int((games["mode"][:] > 1).sum())
print(four, two, team)
