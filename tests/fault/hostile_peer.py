"""Speaks to a learner as nobody should: hostile_peer.py PORT connections COUNT SECONDS
                                          hostile_peer.py PORT endless MEGABYTES

connections: keeps COUNT bare TCP connections open, new ones for those that are closed.
endless: one-byte frames of one message that does not end, as ZMTP 3.0 without keys.
"""

import resource
import select
import socket
import sys
import time


def connect(port):
    return socket.create_connection(("127.0.0.1", port), timeout=2)


def hold(port, count, seconds):
    """Prints how many connections were made in all."""
    poll = select.epoll()
    peers = {}
    made = 0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        while len(peers) < count:
            try:
                peer = connect(port)
            except OSError:
                break  # its queue is full
            made += 1
            peers[peer.fileno()] = peer
            poll.register(peer.fileno(), select.EPOLLRDHUP | select.EPOLLHUP)
        for descriptor, _ in poll.poll(0.05):
            poll.unregister(descriptor)
            peers.pop(descriptor).close()
    print(made)


def say(port, megabytes):
    """Prints how many bytes were taken."""
    peer = connect(port)
    peer.sendall((b"\xff" + bytes(8) + b"\x7f\x03\x00NULL").ljust(64, b"\0"))
    peer.sendall(b"\x04\x1c\x05READY\x0bSocket-Type\x00\x00\x00\x06DEALER")
    time.sleep(0.5)
    frames = b"\x01\x01x" * 20_000
    taken = 0
    try:
        while taken < megabytes << 20:
            taken += peer.send(frames)
    except OSError:
        pass
    print(taken)


hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
if sys.argv[2] == "connections":
    hold(int(sys.argv[1]), int(sys.argv[3]), float(sys.argv[4]))
else:
    say(int(sys.argv[1]), int(sys.argv[3]))
