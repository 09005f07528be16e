"""The process that the service starts at the first cell: `python -m server.cells LINE_FD PARENT_PID`."""

import logging
import os
import socket
import sys

from server.base.children import die_with


def main(line: int, parent: int) -> None:
    die_with(parent)
    logging.basicConfig(level=logging.WARNING, format="%(asctime)s %(levelname)s cells %(name)s: %(message)s")
    from server.cells.process import serve

    os.set_inheritable(line, False)  # no child of ours may keep the line open after our death
    serve(socket.socket(fileno=line))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
