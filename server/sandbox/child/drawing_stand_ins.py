"""Stand-ins for libraries that draw: nothing is drawn while a program is graded, and nothing fails for it.

Every name of such a module is the same object, which gives itself whatever is done with it.
"""

from __future__ import annotations

import opcode
import sys
from importlib.machinery import ModuleSpec
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

#: Names that `from … import *` gives, by module; pylab gives numpy's too.
_PLOT_NAMES = """
annotate arrow axes axhline axis axvline bar cla clf close cm colorbar contour contourf draw errorbar figure fill
fill_between gca gcf grid hist hist2d imshow ioff ion legend loglog matshow pause pcolormesh pie plot quiver savefig
scatter semilogx semilogy show stem step subplot subplots subplots_adjust suptitle text tight_layout title xlabel xlim
xticks ylabel ylim yticks
"""
_TURTLE_NAMES = """
Screen Turtle back backward begin_fill bgcolor bk circle clear color done dot down end_fill exitonclick fd fillcolor
forward goto heading hideturtle home ht isdown left lt mainloop pd pendown pensize penup pos position pu reset right rt
seth setheading setpos setup setx sety shape showturtle speed st stamp title towards tracer undo up update width write
xcor ycor
"""
_TKINTER_NAMES = """
BOTH BOTTOM Button Canvas Checkbutton END Entry Frame HORIZONTAL Label LEFT Listbox Menu RIGHT Scale StringVar Text Tk
TOP Toplevel VERTICAL IntVar DoubleVar BooleanVar PhotoImage messagebox mainloop
"""
_NAMES = {
    "matplotlib.pyplot": _PLOT_NAMES,
    "pylab": _PLOT_NAMES,
    "matplotlib.pylab": _PLOT_NAMES,
    "turtle": _TURTLE_NAMES,
    "tkinter": _TKINTER_NAMES,
}
#: The libraries that are stood in for.
ROOTS = frozenset(
    (
        *("matplotlib", "pylab", "mpl_toolkits", "seaborn", "plotly", "bokeh", "altair", "turtle", "tkinter"),
        *("IPython", "ipywidgets"),
    )
)
_UNPACK_SEQUENCE, _UNPACK_EX = opcode.opmap["UNPACK_SEQUENCE"], opcode.opmap["UNPACK_EX"]


class Dessin:
    """A drawing that is not made; its name is what a message says of one that a function returns."""

    def __init__(self, *_: object, **__: object) -> None: ...

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Return itself; used as a decorator, return what it decorates."""
        if len(arguments) == 1 and not named and isinstance(arguments[0], FunctionType):
            return arguments[0]
        return self

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __iter__(self) -> Any:
        """Give as many of itself as the line that unpacks it wants, as in `fig, (a, b) = subplots(1, 2)`."""
        return iter((self,) * _count_unpacked_values(sys._getframe(1)))

    def __setattr__(self, name: str, value: object) -> None: ...

    def __setitem__(self, key: object, value: object) -> None: ...

    def __exit__(self, *_: object) -> None: ...

    def __len__(self) -> int:
        return 1

    def __bool__(self) -> bool:
        return True

    def __float__(self) -> float:
        return 0.0

    def _self(self, *_: Any) -> Any:
        return self

    def _false(self, *_: Any) -> bool:
        return False

    __getitem__ = __enter__ = __next__ = _self
    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = __neg__ = _self
    __lt__ = __gt__ = __le__ = __ge__ = _false
    __array_ufunc__ = None


NOTHING = Dessin()


def _count_unpacked_values(frame: Any) -> int:
    """Return how many values the instruction that iterates unpacks; 1 for a loop."""
    code, at = frame.f_code.co_code, frame.f_lasti
    if code[at] == _UNPACK_SEQUENCE:
        return int(code[at + 1])
    return int(code[at + 1]) + 1 if code[at] == _UNPACK_EX else 1


class _StandInModule(ModuleType):
    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return NOTHING


class StandInFinder:
    """Import hook for these libraries, unless it is not `enabled`; `used` holds those that were imported."""

    def __init__(self) -> None:
        self.enabled = True
        self.used: list[str] = []

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        if not self.enabled or fullname.partition(".")[0] not in ROOTS:
            return None
        loader: Any = self
        return ModuleSpec(fullname, loader, is_package=True)

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        return _StandInModule(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        names = _NAMES.get(module.__name__, "").split()
        vars(module).update(dict.fromkeys(names, NOTHING), __version__="", __file__="")
        if module.__name__ in ("pylab", "matplotlib.pylab"):
            names += [name for name in np.__all__ if name not in names]
            vars(module).update({name: getattr(np, name) for name in np.__all__}, np=np)
            names.append("np")
        vars(module)["__all__"] = names
        if "." not in module.__name__:
            self.used.append(module.__name__)


STAND_INS = StandInFinder()


def get_ipython() -> Dessin:
    """Stand in for the shell of a notebook."""
    return NOTHING


def display(*_: object, **__: object) -> None:
    """Stand in for the display of a notebook."""
