"""The process that `balise serve` starts for each worker: `python -m server.grading CHANNEL_FD PARENT_PID`."""

import os
import socket
import sys

from server.base.children import die_with
from server.grading.process import run, start_logging, stop_on_signals
from server.queue.worker import Stop


def main(channel_fd: int, parent: int) -> None:
    die_with(parent)
    stop_on_signals()
    start_logging(f"worker[{channel_fd}]")
    from server.base.settings import Settings
    from server.queue.channel import Channel

    os.set_inheritable(channel_fd, False)  # no child of ours may keep the line open after our death
    channel = Channel(socket.socket(fileno=channel_fd))
    try:
        run(Settings(), channel, channel)
    except Stop:
        sys.exit(0)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
