"""Prints the ticket of every game in a replay folder, one a line: stored_tickets.py FOLDER."""

import pathlib
import sys

import h5py

for path in sorted(pathlib.Path(sys.argv[1]).glob("segment-*.h5")):
    try:
        with h5py.File(path) as segment:
            print(*segment["games/ticket"][:], sep="\n")
    except FileNotFoundError:
        pass  # merged into another segment meanwhile
