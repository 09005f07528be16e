"""The process that watches an author's files: `python -m server.authoring.preview.watching PARENT FOLDER…`.

It writes one line of JSON, the paths that have changed, each time that some have. In a process of its own: watchfiles
has a thread, and a process that forks should have none.
"""

import json
import os
import sys

from watchfiles import DefaultFilter, watch

from server.base.processes import die_with_parent

#: Milliseconds: an editor writes a file in several strokes.
DEBOUNCE_STEP_MS, MAX_DEBOUNCE_MS = 40, 400


class SourceFilter(DefaultFilter):
    """What an author writes, and not what Python, editors and git leave beside it."""

    ignore_dirs = (*DefaultFilter.ignore_dirs, ".github")


def main(parent: int, folders: list[str]) -> None:
    die_with_parent(parent)
    for changes in watch(
        *folders, watch_filter=SourceFilter(), step=DEBOUNCE_STEP_MS, debounce=MAX_DEBOUNCE_MS, raise_interrupt=False
    ):
        print(json.dumps(sorted({path for _, path in changes})), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), [folder for folder in sys.argv[2:] if os.path.isdir(folder)])
