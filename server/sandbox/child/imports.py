"""Modules that a template imports, so that a submission's own imports cost nothing."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable

#: The standard modules that students use, and the encodings that a source or a text may need.
_STANDARD_MODULES = """
__future__ abc array bisect cmath collections collections.abc contextlib copy dataclasses datetime decimal enum
fractions functools heapq inspect io itertools json linecache math numbers operator pprint queue random re statistics
string struct textwrap threading time timeit traceback types typing warnings weakref
encodings.utf_8_sig encodings.latin_1 encodings.cp1252 encodings.ascii encodings.iso8859_15 encodings.utf_16
"""
_NUMPY = "numpy numpy.linalg numpy.random numpy.fft numpy.polynomial numpy.ma"
_SCIPY = """
scipy.linalg scipy.sparse scipy.sparse.linalg scipy.special scipy.optimize scipy.spatial scipy.spatial.distance
scipy.spatial.transform scipy.ndimage scipy.signal scipy.stats
"""
_MATPLOTLIB = """
matplotlib.pyplot matplotlib.backends.backend_agg matplotlib.patches matplotlib.collections matplotlib.colors
matplotlib.ticker contourpy mpl_toolkits.mplot3d
"""
_SETS = {
    "numpy": _STANDARD_MODULES + _NUMPY,
    "scipy": _STANDARD_MODULES + _NUMPY + _SCIPY,
    "matplotlib": _STANDARD_MODULES + _NUMPY + _MATPLOTLIB,
}


def modules_to_import(imports: str) -> list[str]:
    """Return the names of the modules of an import set."""
    return _SETS[imports].split()


class ForkHookRecorder:
    """Records whether a module outside the standard library registers a fork hook."""

    def __init__(self) -> None:
        self._register, self._has_foreign_hook = os.register_at_fork, False
        os.register_at_fork = self._record  # type: ignore[assignment]

    def _record(self, **hooks: Callable[[], object]) -> None:
        importer = str(sys._getframe(1).f_globals.get("__name__", ""))
        self._has_foreign_hook |= importer.partition(".")[0] not in sys.stdlib_module_names
        self._register(**hooks)

    def stop(self) -> bool:
        """Stop recording; return whether such a hook was registered."""
        os.register_at_fork = self._register
        return self._has_foreign_hook
