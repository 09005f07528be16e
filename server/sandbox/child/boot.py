"""First lines of a template: the namespaces are entered while the process is still small, then numpy is imported."""

from __future__ import annotations

import os
import signal
import sys

from . import outer
from .imports import ForkHookRecorder


def main(control: int, configuration: int, parent: int, namespaces: bool, lifted: list[str], sites: list[str]) -> None:
    """`lifted`: walls left down; `sites`: the directories where numpy and scipy are installed."""
    outer.tie_to_parent(parent)
    forget_inherited_signals()
    control, configuration = move_to_lowest_descriptor(control), move_to_lowest_descriptor(configuration)

    def inside() -> None:
        sys.path += sites
        with open(configuration, "rb", closefd=True) as file:
            data = file.read()
        at_forks = ForkHookRecorder()
        from . import template

        template.start_template(control, data, at_forks)

    if namespaces:
        code = outer.run_in_namespaces(inside, control, lifted)
        os._exit(code if code >= 0 else 70)
    inside()
    os._exit(0)


def move_to_lowest_descriptor(descriptor: int) -> int:
    """Move a file to the lowest free descriptor: with hundreds open, its number could be one that forks use."""
    lowest = os.dup(descriptor)
    os.close(descriptor)
    return lowest


def forget_inherited_signals() -> None:
    """Reset signals that our starter (`nohup`, a profiler) may have blocked: a program's timers need them."""
    signal.pthread_sigmask(signal.SIG_SETMASK, ())
    expected = {signal.SIGPIPE, signal.SIGXFSZ}  # Python ignores these itself
    for number in signal.valid_signals() - expected:
        if signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)
