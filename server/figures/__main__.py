"""The process that the service starts at the first figure: `python -m server.figures LINE_FD PARENT_PID`."""

import sys

from server.base.helper_line import connect_to_service


def main(line: int, parent: int) -> None:
    service = connect_to_service("figures", line, parent)
    from server.figures.process import serve_drawings

    serve_drawings(service)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
