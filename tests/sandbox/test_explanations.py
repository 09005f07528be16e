"""What beginners meet, run in the sandbox: each error is explained in French, with its line and what to write."""

from __future__ import annotations

import builtins
import importlib
import math
import pkgutil
import re
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from server.sandbox import ProgramFault, messages, renamed_names
from server.sandbox.exceptions import describe_exception
from server.sandbox.explanations import explain_error, explain_import
from server.sandbox.faults import Frame
from tests.support.tables import folded

FaultOf = Callable[..., ProgramFault]
HEAD = "import math\nimport numpy as np\n\n\n"


def plain(text: str) -> str:
    return text.replace("\u00a0", " ")


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("return np.product(v)", "np.product a disparu de NumPy 2 : np.prod le remplace"),
        ("return np.float(x)", "np.float a disparu de NumPy 2 : float le remplace"),
        ("return np.Inf", "np.Inf a disparu de NumPy 2 : np.inf le remplace"),
        ("return np.trapz(v)", "np.trapz a disparu de NumPy 2 : np.trapezoid le remplace"),
        ("return np.arctang(x)", "Vouliez-vous dire np.arctan ?"),
        ("return np.ln(x)", "écrivez np.log"),
        ("return v.ptp()", "La méthode ptp a disparu de NumPy 2 : np.ptp(a) la remplace"),
        ("return {}.has_key(1)", "La méthode has_key a disparu de Python 3 : cle in dictionnaire"),
        ("return v.append(1)", "Un tableau n’a pas de « append » : np.append"),
        ("import time; return time.clock()", "time.clock a disparu de Python 3 : time.perf_counter le remplace"),
        ("import fractions; return fractions.gcd(4, 6)", "fractions.gcd a disparu de Python 3 : math.gcd"),
        ("from numpy import product", "np.product a disparu de NumPy 2 : np.prod"),
        ("from collections import Mapping", "collections.Mapping a disparu de Python 3 : collections.abc.Mapping"),
        ("import cPickle", "Le module « cPickle » a disparu de Python 3 : pickle le remplace"),
        ("return xrange(3)", "xrange a disparu de Python 3 : range le remplace"),
        ("return cos(x)", "« cos » est dans numpy : écrivez np.cos"),
        ("return pi * x", "En Python, cela s’écrit np.pi"),
        ("return random.random()", "« import random » en tête du fichier"),
        ("return true", "En Python, cela s’écrit True"),
        ("return dtheta", "Vouliez-vous dire dteta (ligne 6) ?"),
        ("return X", "Vouliez-vous dire x (ligne 5) ?"),
        ("return ailleurs", "« ailleurs » n’existe que dans la fonction « g » (ligne 12)"),
        ("return tеta", "« е » de l’alphabet cyrillique (U+0435) : retapez « teta » au clavier"),
        ("return lrn(v)", "Vouliez-vous dire len ?|nulle part"),
        ("y = y + 1", "est lue avant d’avoir reçu une valeur dans la fonction : elle en reçoit une ligne 8"),
        ("return v[x]", "un nombre entier (v[x]) : int(x) ? Ici : v est un tableau de forme (3,), x vaut 2,5"),
        ("return [1, 2][x]", "Un indice doit être un nombre entier"),
        ("return [[1], [2]][0, 0]", "Une liste n’a qu’un indice : écrivez l[i][j]"),
        ("return range(x)", "Il faut ici un nombre entier : int(…), ou // pour une division entière. Ici : x vaut 2,5"),
        ("return v[0, 1]", "Ce tableau a 1 dimension, et 2 indices"),
        ("return v[7]", "L’indice 7 sort du tableau : l’axe 0 a 3 éléments"),
        ("return x ^ 2", "la puissance s’écrit ** et non ^ : x**2"),
        ("return v^2", "la puissance s’écrit ** et non ^ : v**2"),
        ("return 2(x)", "Il manque un signe « * » : 2 * (…)"),
        ("return v(0)", "Un tableau n’est pas une fonction : un élément s’écrit a[i]"),
        ("return math.cos(v)", "math.cos ne prend qu’un nombre, et reçoit un tableau : np.cos prend des tableaux"),
        ("return float(v)", "float(…) ne prend qu’un nombre, et reçoit un tableau (NumPy 1"),
        ("return float(np.array([x]))", "a[0], ou a.item(), donne cet élément"),
        ("return v + 'a'", "« + » ne s’applique qu’à des nombres"),
        ("return x + 'a'", "« + » ne s’applique pas entre un nombre et une chaîne de caractères"),
        ("return x + g(1)", "« + » ne s’applique pas à None"),
        ("return x * g", "les parenthèses de son appel sont-elles oubliées ?"),
        ("return g[1]", "Une fonction s’appelle avec des parenthèses"),
        ("return m @ v[:2]", "à gauche 3 colonnes, à droite 2 lignes ; il en faut autant. Ici : m est un tableau"),
        ("return m @ m", "Ici : m est un tableau de forme (2, 3)"),
        ("return m @ m.T @ m.T", "m.T est un tableau de forme (3, 2)"),
        ("return np.dot(m, v[:2])", "Produit impossible entre les formes (2, 3) et (2,) : 3 à gauche, 2 à droite"),
        ("return v + v[:2]", "formes qui vont ensemble : (3,) et (2,)"),
        ("return 0,5 * x + (0,5) * x", "« 0,5 » fait deux nombres, 0 et 5 : en Python, on écrit 0.5"),
        ("return np.array([[1], [2, 3]])", "Toutes les lignes d’un tableau doivent avoir la même longueur"),
        ("return 1 if v > 0 else 2", "(…).all() s’ils doivent l’être tous"),
        ("a, b = v", "À gauche du signe « = », 2 noms ; à droite, plus de valeurs"),
        ("return np.array(v.tolist(), copy=False)", "s’écrit np.asarray(…)"),
        ("return math.sqrt(-x)", "la racine d’un nombre négatif"),
        ("return g(1, 2)", "« g » prend 1 argument, et en reçoit 2"),
        ("return g()", "Il manque à l’appel de g : argument"),
        ("return np.zeros(2, 3)", "entre parenthèses : np.zeros((2, 3))"),
        ("return np.linalg.inv(m)", "Il faut une matrice carrée"),
    ],
)  # fmt: skip
def test_an_error_is_explained_with_its_line(fault_of: FaultOf, line: str, told: str) -> None:
    source = (
        f"{HEAD}def f(x, v, m):\n    dteta = x\n    teta = x\n    {line}\n\n\n"
        "def g(argument):\n    ailleurs = argument\n"
    )
    fault = fault_of(source, 2.5, np.arange(3.0), np.ones((2, 3)))
    message = plain(fault.message)
    assert any(piece in message for piece in told.split("|")), message
    assert message.startswith("Ligne 8")
    assert fault.line == 8
    assert len(message) < 600


def test_only_exact_types_are_looked_at(fault_of: FaultOf) -> None:
    """No method of the student runs while an error is told, and long values are cut."""
    source = (
        "import numpy as np\n\n\nclass Piege(float):\n    def __format__(self, spec):\n        raise SystemExit\n\n\n"
        "class Tableau(np.ndarray):\n    @property\n    def shape(self):\n        raise SystemExit\n\n\n"
        "def f(v):\n    p, t, s = Piege(2.0), v.view(Tableau), 'x' * 10000\n    return v[p] + t + s\n"
    )
    message = plain(fault_of(source, np.arange(3.0)).message)
    assert "v est un tableau de forme (3,), s est une chaîne de caractères" in message
    assert len(message) < 600


NAMESPACE: dict[str, Any] = {"np": np, "math": math, "numpy": np}


@folded("name", sorted(renamed_names.NUMPY))
def test_the_table_of_numpy_fits_the_library_served(name: str) -> None:
    """An old name is gone, or goes with a warning; what is written instead exists."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if hasattr(np, name):
            assert name == "row_stack"
            return
        with pytest.raises(AttributeError) as refused:
            getattr(np, name)
    told = explain_error("AttributeError", str(refused.value), "", (), ())
    assert told
    assert told.startswith(f"np.{name} a disparu de NumPy 2 : ")
    for written in re.findall(r"np\.[\w.]+", told.split(" : ")[1]):
        eval(written.rstrip("."), NAMESPACE)


@pytest.mark.parametrize("module", sorted(renamed_names.ATTRIBUTES))
def test_the_other_tables_fit_what_is_served(module: str) -> None:
    instances = {"numpy.ndarray": np.zeros(1), "list": [], "tuple": (), "dict": {}, "str": ""}
    instances |= {"generator": (x for x in ()), "list_iterator": iter([]), "range_iterator": iter(range(1))}
    owner = instances[module] if module in instances else importlib.import_module(module)
    for name, instead in renamed_names.ATTRIBUTES[module].items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert not hasattr(owner, name) or (module, name) == ("numpy.random", "random_integers")
        for path in re.findall(r"\b(?:scipy|np|math|collections|time|sys|string|inspect|os)(?:\.\w+)+", instead):
            assert pkgutil.resolve_name(path.replace("np.", "numpy.")) is not None
        if owner is not instances.get(module):
            with pytest.raises(AttributeError) as refused:
                getattr(owner, name) if not hasattr(owner, name) else getattr(owner, f"{name}_")
            if not hasattr(owner, name):
                assert instead in (explain_error("AttributeError", str(refused.value), "", (), ()) or "")


def test_names_of_python_2_are_gone_and_their_successors_are_not() -> None:
    for name, instead in renamed_names.BUILTINS.items():
        assert not hasattr(builtins, name)
        told = explain_error("NameError", f"name '{name}' is not defined", "", (), ())
        assert told == f"{name} a disparu de Python 3 : {instead} le remplace."
    for name in renamed_names.MODULES:
        assert "a disparu" in (explain_import("ModuleNotFoundError", name, "") or "")


def test_an_error_that_nobody_explains_keeps_what_its_type_means() -> None:
    message = messages.runtime_error("AttributeError", "module 'numpy' has no attribute 'int'.\nmore\nand more", 1, ())
    assert "more" not in message
    assert "np.int a disparu" in message
    assert "Un diviseur est nul" in messages.runtime_error("ZeroDivisionError", "division by zero", 1, ())
    assert explain_error("ValueError", "quelque chose", "x vaut 1", (), ()) is None
    told = messages.runtime_error("ValueError", "something odd", 1, (), "x vaut 1")
    assert "odd" not in told
    assert "Ici : x vaut 1" in told
    assert "type « EtrangeErreur »" in messages.runtime_error("EtrangeErreur", "odd", 1, ())


def test_a_file_of_many_names_costs_little() -> None:
    """Whatever a hostile file holds: the nearest name is sought among some of its names, which are found once."""
    lines = tuple(f"nom_{number} = {number}" for number in range(5000))
    for _ in range(5):
        assert explain_error("NameError", "name 'nom_x' is not defined", "", (), lines)
    assert explain_error("NameError", "name 'x' is not defined", "", (), ("(" * 50_000,))
    assert explain_error("NameError", "name 'x' is not defined", "", (), ("x = 1\n" * 50_000,))


def test_the_field_of_a_message_says_what_it_takes() -> None:
    """ROS 2 itself refuses a whole number there, by an assertion in English."""
    line = Frame(3, "recevoir", "ordre.linear.x = 0")
    told = describe_exception("AssertionError", "The 'x' field must be of type 'float'", [line])
    assert told == "Le champ x de ce message reçoit un nombre à virgule : 0.0 ou float(…), et non 0. [AssertionError]"
