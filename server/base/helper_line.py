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

HEADER = struct.Struct(">IIB")
QUESTION, DONE, FAILED = 0, 1, 2


def encode_frame(number: int, status: int, payload: bytes) -> bytes:
    return HEADER.pack(len(payload), number, status) + payload


#: Helpers leave the processors to graders, pages and whoever else has something to do.
NICE = 5


class ServiceLine:
    """The service's end of the line, for several threads."""

    def __init__(self, end: socket.socket) -> None:
        self._end, self._sending = end, threading.Lock()

    def questions(self) -> Iterator[tuple[int, bytes]]:
        """Number and content of each question, until the service has nothing more to ask.

        What has been imported until now stays.
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


def connect_to_service(name: str, line: int, parent: int) -> ServiceLine:
    """What a helper does first: it ends with the service, is nice, and leaves it to the service to be stopped.

    Ctrl+C, and whoever stops a service with all its processes, tell helpers too: the service ends them in its order.
    """
    die_with_parent(parent)
    gc.disable()  # until the first question: nothing of what is imported is to be collected
    logs.configure_logging(name, os.environ.get("BALISE_LOG_FORMAT", logs.TEXT))
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    os.nice(NICE)
    os.set_inheritable(line, False)  # no child of ours may keep the line open after our death
    return ServiceLine(socket.socket(fileno=line))
