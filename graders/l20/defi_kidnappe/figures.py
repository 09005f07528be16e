"""Figures of l20/defi_kidnappe: those of l20/mcl."""

from graders.l20.mcl.figures import FIGURES

__all__ = ["FIGURES"]
