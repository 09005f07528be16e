"""Client of Balise in one file: standard library alone, Python 3.9 or later.

In a notebook: `%load_ext balise`, then `%%balise l20/poses` at the head of a cell.
"""

from __future__ import annotations

from typing import Any


def load_ipython_extension(shell: Any) -> None:
    """Called by `%load_ext balise`."""
    from . import notebook

    notebook.register_cell_magic(shell)
