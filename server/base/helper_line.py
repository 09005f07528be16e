"""A helper process's side of its socket to the service, and the frames that both sides exchange."""

from __future__ import annotations

import gc
import os
import signal
import socket
import struct
import threading
from collections.abc import Iterator

from server.base import logs
from server.base.processes import die_with_parent

#: A frame is length, number, status, then `length` bytes. An answer has the number of its question; the first
#: message has number 0.
HEADER = struct.Struct(">IIB")
QUESTION, DONE, FAILED = 0, 1, 2


def encode_frame(number: int, status: int, payload: bytes) -> bytes:
    return HEADER.pack(len(payload), number, status) + payload


#: Helpers give way to graders and pages.
NICE = 5


class ServiceLine:
    """The socket to the service. Thread-safe."""

    def __init__(self, end: socket.socket) -> None:
        self._end, self._sending = end, threading.Lock()

    def questions(self) -> Iterator[tuple[int, bytes]]:
        """Yield the number and content of each question, until the service closes the socket.

        Objects that exist by now are never collected (`gc.freeze`).
        """
        gc.freeze()
        gc.enable()
        with self._end.makefile("rb") as stream:
            while len(header := stream.read(HEADER.size)) == HEADER.size:
                length, number, _ = HEADER.unpack(header)
                yield number, stream.read(length)

    def answer(self, number: int, status: int, payload: bytes) -> None:
        with self._sending:
            self._end.sendall(encode_frame(number, status, payload))


def connect_to_service(name: str, descriptor: int, parent: int) -> ServiceLine:
    """Set a helper process up: it dies with its parent, is niced, logs, and ignores SIGINT and SIGTERM.

    Ctrl+C reaches every process of the group: the service stops its helpers itself, in order.
    """
    die_with_parent(parent)
    gc.disable()  # until the first question: imported objects stay
    logs.configure_logging(name, os.environ.get("BALISE_LOG_FORMAT", logs.TEXT))
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    os.nice(NICE)
    os.set_inheritable(descriptor, False)  # no child may keep the socket open after this process has died
    return ServiceLine(socket.socket(fileno=descriptor))
