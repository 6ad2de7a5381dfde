"""Messages between a caller and its child process: pickled whole, as bytes.

Connection.send and recv pickle through a buffer that CPython may free in the wrong order where Ctrl-C arrives in
the middle of them; the process then ends in a segmentation fault instead of with what it has.
"""

from __future__ import annotations

import pickle
from multiprocessing.connection import Connection
from typing import Any

NOTES = COMPILING, COMPILED = "compiling", "compiled"  # sent before an answer: a caller's patience rests between them


def send(pipe: Connection, message: Any) -> None:
    """Send a message; OSError where the other end is gone."""
    pipe.send_bytes(pickle.dumps(message))


def receive(pipe: Connection) -> Any:
    """Return the next message, waiting for it; EOFError or ConnectionError where the other end is gone."""
    return pickle.loads(pipe.recv_bytes())
