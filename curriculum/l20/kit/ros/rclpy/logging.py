"""Le journal d'un nœud : des lignes datées, écrites sur la sortie d'erreur."""

import sys
from enum import IntEnum

from rclpy import simulation


class LoggingSeverity(IntEnum):
    UNSET = 0
    DEBUG = 10
    INFO = 20
    WARN = 30
    ERROR = 40
    FATAL = 50


class RcutilsLogger:
    """`info("…", throttle_duration_sec=2.0)` : pas plus d'une ligne toutes les deux secondes. `once`, `skip_first`."""

    def __init__(self, name=""):
        self.name = name
        self._seuil = LoggingSeverity.INFO
        self._vues = {}

    def get_child(self, name):
        if not name:
            raise ValueError("Child logger name must not be empty.")
        return RcutilsLogger(f"{self.name}.{name}" if self.name else name)

    def set_level(self, level):
        self._seuil = LoggingSeverity(level)

    def get_effective_level(self):
        return self._seuil

    def is_enabled_for(self, severity):
        return severity >= self._seuil

    def debug(self, message, **options):
        return self.log(message, LoggingSeverity.DEBUG, **options)

    def info(self, message, **options):
        return self.log(message, LoggingSeverity.INFO, **options)

    def warning(self, message, **options):
        return self.log(message, LoggingSeverity.WARN, **options)

    def warn(self, message, **options):
        return self.log(message, LoggingSeverity.WARN, **options)

    def error(self, message, **options):
        return self.log(message, LoggingSeverity.ERROR, **options)

    def fatal(self, message, **options):
        return self.log(message, LoggingSeverity.FATAL, **options)

    def log(
        self,
        message,
        severity,
        name=None,
        *,
        once=False,
        skip_first=False,
        throttle_duration_sec=None,
        throttle_time_source_type=None,
    ):
        severity = LoggingSeverity(severity)
        if not self._passe(_appelant(), once, skip_first, throttle_duration_sec) or severity < self._seuil:
            return False
        secondes, reste = divmod(simulation.monde().maintenant, simulation.SECONDE)
        print(f"[{severity.name}] [{secondes}.{reste:09d}] [{name or self.name}]: {message}", file=sys.stderr)
        return True

    def _passe(self, ligne, once, skip_first, duree):
        """Chaque ligne du programme a son propre compte."""
        if not (once or skip_first or duree is not None):
            return True
        maintenant = simulation.monde().maintenant
        fois, derniere = self._vues.get(ligne, (0, None))
        passe = not (once and fois) and not (skip_first and not fois)
        if passe and duree is not None and derniere is not None:
            passe = maintenant - derniere >= duree * simulation.SECONDE
        self._vues[ligne] = (fois + 1, maintenant if passe else derniere)
        return passe


def _appelant():
    """Le fichier et la ligne qui écrivent au journal."""
    cadre = sys._getframe(1)
    while cadre.f_globals.get("__name__") == __name__:
        cadre = cadre.f_back
    return cadre.f_code.co_filename, cadre.f_lineno


def get_logger(name):
    if not name:
        raise ValueError("Logger name must not be empty.")
    return RcutilsLogger(name)


def set_logger_level(name, level, detailed_error=False):
    """Sans effet ici : chaque journal a son niveau, par `set_level`."""
    return True
