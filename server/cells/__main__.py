"""The process that the service starts at the first cell: `python -m server.cells LINE_FD PARENT_PID`."""

import sys

from server.base.helper_line import connect_to_service


def main(line: int, parent: int) -> None:
    service = connect_to_service("cells", line, parent)
    from server.cells.process import serve_cells

    serve_cells(service)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
