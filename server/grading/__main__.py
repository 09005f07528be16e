"""The process that `balise serve` starts for each worker: `python -m server.grading CHANNEL_FD PARENT_PID`."""

import gc
import logging
import os
import socket
import sys

from server.base import logs, traces
from server.base.processes import die_with_parent


def main(channel_fd: int, parent: int) -> None:
    die_with_parent(parent)
    gc.disable()  # imports stay: `run_worker` freezes them, then enables collection again
    from server.base.settings import Settings
    from server.grading.worker_process import run_worker, stop_on_signals
    from server.queue.graceful_stop import StopRequested
    from server.queue.worker_channel import WorkerChannel

    stop_on_signals()

    os.set_inheritable(channel_fd, False)  # no child may keep the channel open after this process
    channel = WorkerChannel(socket.socket(fileno=channel_fd))
    settings = Settings()
    logs.configure_logging(f"worker[{channel_fd}]", settings.log_format, logging.INFO)
    traces.start_tracing(f"worker[{channel_fd}]")
    try:
        run_worker(settings, channel, channel, channel.template_renewed)
    except StopRequested:
        sys.exit(0)
    finally:
        traces.stop_tracing()


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
