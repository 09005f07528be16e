"""Ctrl-C : ici, c'est le monde simulé qui le tape, quand il n'a plus rien à dire."""

from enum import IntEnum


class SignalHandlerOptions(IntEnum):
    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


def install_signal_handlers(options=SignalHandlerOptions.ALL):
    """Rien à installer."""


def uninstall_signal_handlers():
    """Rien à retirer."""
