"""Exclusive lock of a data folder: one server or restoration at a time."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager

from server.base.settings import Settings
from server.cli import CommandError


@contextmanager
def lock_data_folder(settings: Settings) -> Iterator[None]:
    """Lock a data folder: two servers would take each other's workers for dead."""
    try:
        settings.data_dir.mkdir(mode=0o700, parents=True, exist_ok=True)
        lock = (settings.data_dir / "balise.lock").open("a")  # whose it is stays written there
    except OSError as error:
        raise CommandError(f"le dossier des données {settings.data_dir} ne convient pas : {error.strerror}.") from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise CommandError(
                f"un autre serveur utilise déjà {settings.data_dir} (autre dossier : --data)."
            ) from error
        lock.truncate(0)
        lock.write(f"{os.getpid()}\n")
        lock.flush()
        yield
