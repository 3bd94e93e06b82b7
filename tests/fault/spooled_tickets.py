"""Prints the ticket of every game in a spool (actors/selfplay/outbox.h), one a line."""

import pathlib
import struct
import sys

data = pathlib.Path(sys.argv[1]).read_bytes()
at = len("PKSPOOL1")
while at + 16 <= len(data):
    size, _, ticket = struct.unpack_from("<IIQ", data, at)
    print(ticket)
    at += 8 + size
