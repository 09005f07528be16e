"""Calls of what is no function, or with the wrong arguments."""

from __future__ import annotations

import re

import numpy as np

from server.sandbox.explanations.patterns import NUMBER, OR_NONE, Pattern, called_function, plural, told
from server.sandbox.explanations.types import describe_type


def _explain_call(match: re.Match[str], source: str) -> str:
    kind = match[1]
    number = re.search(rf"(?<![\w.])({NUMBER})\s*\(", source)
    if number:
        return f"Il manque un signe « * » : {number[1]} * (…). « {number[1]}(…) » appelle une fonction."
    attribute = re.search(r"\.(shape|size|ndim|T|dtype|real|imag|pi|e|inf|nan)\s*\(", source)
    if attribute:
        return f"« .{attribute[1]} » se lit sans parenthèses : ce n’est pas une fonction."
    what = describe_type(kind)
    if "ndarray" in kind:
        return "Un tableau n’est pas une fonction : un élément s’écrit a[i], un produit a * (…) ou a @ b."
    if kind == "module":
        module = re.search(r"\b(\w+)\s*\(", source)
        name = module[1] if module else "module"
        return f"« {name} » est un module, pas une fonction : {name}.f(…) appelle une de ses fonctions."
    if kind in ("list", "dict", "str", "tuple"):
        return f"Ce qui est appelé est {what}, pas une fonction : un élément s’écrit avec des crochets, l[i]."
    return (
        f"Ce qui est appelé est {what}, pas une fonction : manque-t-il un signe « * », ou ce nom a-t-il été réutilisé ?"
    )


def _explain_one_number(match: re.Match[str], source: str) -> str:
    called = re.search(r"\bmath\.(\w+)\s*\(", source)
    if called and hasattr(np, called[1]):
        return f"math.{called[1]} ne prend qu’un nombre, et reçoit un tableau : np.{called[1]} prend des tableaux."
    called = re.search(r"\b(float|int|complex)\s*\(", source)
    if called:
        return (
            f"{called[1]}(…) ne prend qu’un nombre, et reçoit un tableau (NumPy 1 acceptait celui d’un seul élément) : "
            "a[0], ou a.item(), donne cet élément."
        )
    return "Il faut ici un seul nombre, et non un tableau : a[0] ou a.item() en donne l’élément, s’il n’en a qu’un."


def _explain_arguments(match: re.Match[str], source: str) -> str:
    function, takes, given = match.groups()
    return _wrong_count_sentence(function, takes, given)


def _wrong_count_sentence(function: str, takes: str, given: str) -> str:
    if function.startswith("__init__"):
        return f"La construction de cet objet prend {_counted(takes, self_too=True)}, et en reçoit {int(given) - 1}."
    count = takes.replace("from", "de").replace("to", "à")
    return f"« {function.lstrip('_')} » prend {plural(count, 'argument')}, et en reçoit {given}."


def _counted(takes: str, *, self_too: bool) -> str:
    numbers = [int(it) - self_too for it in re.findall(r"\d+", takes)]
    return plural(str(numbers[0]), "argument") if len(numbers) == 1 else f"de {numbers[0]} à {numbers[-1]} arguments"


def _explain_method_arguments(match: re.Match[str], source: str) -> str:
    """The object before the point is an argument, which a student does not write."""
    owner, function, takes, given = match.groups()
    if function == "__init__":
        return f"{owner}(…) prend {_counted(takes, self_too=True)}, et en reçoit {int(given) - 1}."
    return (
        f"« {owner}.{function} » prend {_counted(takes, self_too=True)} (outre self, l’objet lui-même), et en reçoit "
        f"{int(given) - 1}."
    )


def _explain_missing(match: re.Match[str], source: str) -> str:
    function, names = match.groups()
    written = names.replace(" and ", " et ").replace("'", "").replace(", et ", " et ")
    owner, _, name = function.rpartition(".")
    if name == "__init__":
        function = owner.rpartition(".")[2]
    elif "lambda" in function:
        function = "la fonction lambda"
    else:
        function = name
    of = "d’" if len(function) > 1 and function[0] in "aeiou" else "de "
    return f"Il manque à l’appel {of}{function} : {written}."


def _explain_real(match: re.Match[str], source: str) -> str:
    kind = next(group for group in match.groups() if group)
    function = called_function(source) or ("« % »" if "%" in source else "Cette fonction")
    if kind == "NoneType":
        return f"{function} attend un nombre, et reçoit None : {OR_NONE}"
    cure = ""
    if kind == "complex":
        cure = " (np.cos, np.sqrt… prennent des complexes ; z.real en donne la partie réelle)"
    elif kind in ("list", "tuple"):
        cure = " : np.array(…) et les fonctions de numpy calculent sur plusieurs nombres à la fois"
    return f"{function} attend un nombre, et reçoit {describe_type(kind)}{cure}."


#: Texts of Python and numpy about calls, and what explains them; the first that matches counts.
PATTERNS: tuple[Pattern, ...] = (
    (r"only 0-dimensional arrays can be converted|only (?:length|size)-1 arrays can be converted", _explain_one_number),
    (r"'([\w.]+)' object is not callable", _explain_call),
    (r"\w+\(\) argument must be a (?:string|.*real number).*, not '([\w.]+)'", _explain_real),
    (r"must be real number, not ([\w.]+)|a real number is required, not ([\w.]+)", _explain_real),
    (
        r"Cannot interpret '(.*)' as a data type|Field elements must be",
        told("La forme d’un tableau se donne en un seul argument, entre parenthèses : np.zeros((2, 3))."),
    ),
    (
        r"^(?:[\w.<>]+\.)?(\w+)\.(\w+)\(\) takes (\d+|from \d+ to \d+) positional arguments? but (\d+) (?:was|were) "
        r"given",
        _explain_method_arguments,
    ),
    (
        r"^(\w+)\(\) takes (?:at most |at least |exactly )?(\d+|from \d+ to \d+) (?:positional )?arguments? "
        r"(?:but|\()\s*(\d+)",
        _explain_arguments,
    ),
    (
        r"^(?:[\w.]+\.)?(\w+)(?:\(\))? (?:takes|expected) (?:exactly |at least |at most )?(\d+|one|no) "
        r"(?:positional )?arguments?,? (?:\(|got |but )(\d+)",
        lambda match, source: _wrong_count_sentence(
            called_function(source) if match[1] == "function" else match[1],
            {"one": "1", "no": "0"}.get(match[2], match[2]),
            match[3],
        ),
    ),
    (r"^(?:[\w.]+\.)?(\w+)\(\) takes no (?:keyword )?arguments", told("« {0} » ne prend pas cet argument.")),
    (r"^([\w.<>]+)\(\) missing \d+ required (?:positional|keyword-only) arguments?: (.*)", _explain_missing),
    (r"^([aeiou]\w+)\(\) missing required argument '(\w+)'", told("Il manque à l’appel d’{0} : {1}.")),
    (r"^(\w+)\(\) missing required argument '(\w+)'", told("Il manque à l’appel de {0} : {1}.")),
    (r"(\w+)\(\) must have at least (?:two|2) arguments", told("« {0} » prend 2 arguments au moins.")),
    (
        r"got an unexpected keyword argument '(\w+)'|'(\w+)' is an invalid keyword argument",
        lambda match, source: f"Cette fonction n’a pas d’argument nommé « {match[1] or match[2]} ».",
    ),
    (
        r"(\w+)\(\) got multiple values for argument '(\w+)'",
        told("« {0} » reçoit deux fois l’argument {1} : par sa place, puis par son nom."),
    ),
    (
        r"(\w+)\(\) got some positional-only arguments passed as keyword arguments: '(.*)'",
        told("« {0} » reçoit ses arguments par leur place, sans nom : {1}."),
    ),
    (
        r"(\w+)\(\) argument after \* must be an iterable, not (\w+)",
        lambda match, source: (
            f"« *… » donne à {match[1]} les éléments d’une liste un à un, et c’est {describe_type(match[2])}."
        ),
    ),
    (
        r"(\w+)\(\) argument after \*\* must be a mapping, not (\w+)",
        lambda match, source: f"« **… » se met devant un dictionnaire, et c’est {describe_type(match[2])}.",
    ),
    (
        r"^(\w+)\(\) cannot take an object of type '([\w.]+)'",
        lambda match, source: f"« {match[1]} » ne prend pas {describe_type(match[2])} : des nombres, ou des tableaux.",
    ),
    (
        r"return arrays must be of ArrayType",
        lambda match, source: (
            f"{called_function(source) or 'Cette fonction'} prend un argument de moins : le dernier n’est pas un "
            f"nombre de "
            "plus, mais un tableau où ranger le résultat."
        ),
    ),
)
