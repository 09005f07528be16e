"""Values of the wrong type, operators between them, and calls with the wrong arguments."""

from __future__ import annotations

import re

import numpy as np

from server.sandbox.explanations import libraries, shapes
from server.sandbox.explanations.patterns import (
    NUMBER,
    OR_NONE,
    Pattern,
    called_function,
    first_sentence,
    plural,
    said,
    told,
)
from server.sandbox.explanations.types import CALLABLE_TYPES, capitalise, describe_type


def explain_value(text: str, values: str, source: str) -> str | None:
    """Return the explanation of an exception by its text, with what the names on its line are; None for none."""
    sentence = first_sentence((*_PATTERNS, *shapes.PATTERNS, *libraries.PATTERNS), text, source)
    return None if sentence is None else with_values(sentence, values)


def with_values(sentence: str, values: str) -> str:
    """Return a sentence, followed by what the names on the guilty line are."""
    return f"{sentence} Ici : {values}." if values else sentence


def _explain_operator(match: re.Match[str], source: str) -> str:
    operator, left, right = match.groups()
    operator = operator.split(" ", maxsplit=1)[0]
    if operator in ("^", "^="):
        return _power(source)
    if operator == ">>" and "print" in source:
        return "« print » est une fonction : print(…), avec des parenthèses."
    if "NoneType" in (left, right):
        return f"« {operator} » ne s’applique pas à None : {OR_NONE}"
    if comma := _comma(source):
        return comma
    called = next((it for it in (left, right) if it in CALLABLE_TYPES), None)
    if called:
        return f"« {operator} » ne s’applique pas à une fonction : les parenthèses de son appel sont-elles oubliées ?"
    cure = ""
    if {left, right} & {"list", "tuple"} and operator not in ("in", "not"):
        cure = " : np.array(…) fait d’une liste un tableau, et calcule terme à terme"
    elif {left, right} & {"str", "numpy.str_"}:
        cure = " : float(…) lit le nombre qu’une chaîne écrit, str(…) fait l’inverse"
    elif operator == "@":
        cure = " : « @ » est le produit de tableaux ; entre nombres, c’est « * »"
    elif operator in ("&", "|", "~"):
        cure = " : entre deux conditions, c’est « and », « or », « not »"
    return f"« {operator} » ne s’applique pas entre {describe_type(left)} et {describe_type(right)}{cure}."


def _explain_comparison(match: re.Match[str], source: str) -> str:
    operator, left, right = match.groups()
    if "NoneType" in (left, right):
        return f"« {operator} » ne compare pas à None : {OR_NONE}"
    if {left, right} & set(CALLABLE_TYPES):
        return f"« {operator} » ne compare pas une fonction : les parenthèses de son appel sont-elles oubliées ?"
    if "complex" in (left, right):
        return (
            f"« {operator} » ne s’applique pas à un nombre complexe : lequel est le plus grand ? np.abs(z) en "
            f"est un réel."
        )
    return f"« {operator} » ne compare pas {describe_type(left)} à {describe_type(right)}."


def _explain_sign(match: re.Match[str], source: str) -> str:
    operator, kind = match[1].rstrip(":"), match[2]
    operator = {"unary -": "-", "unary +": "+", "unary ~": "~"}.get(operator, operator)
    if kind == "NoneType":
        return f"« {operator} » ne s’applique pas à None : {OR_NONE}"
    cure = " : np.array(…) en fait un tableau" if kind in ("list", "tuple") else ""
    return f"« {operator} » ne s’applique pas à {describe_type(kind)}{cure}."


def _power(source: str) -> str:
    match = re.search(r"([\w.]+(?:\([^()]*\))?|\([^()]*\))\s*\^\s*([\w.]+|\([^()]*\))", source)
    example = f" : {match[1]}**{match[2]}" if match else ""
    return f"En Python, la puissance s’écrit ** et non ^{example}."


def _comma(source: str) -> str | None:
    number = re.search(r"(?<![\w.,])\d+,\d+(?![\w.,])", source)
    return _decimal_comma(number[0]) if number else None


def _decimal_comma(number: str) -> str:
    """« 0,5 » is two numbers, and 0.5 is one."""
    both, right = number.replace(",", " et "), number.replace(",", ".")
    return f"« {number} » fait deux nombres, {both} : en Python, on écrit {right}."


def _explain_product(match: re.Match[str], source: str) -> str:
    if comma := _comma(source):
        return comma
    kind = match[1]
    if kind in ("list", "tuple", "str"):
        return (
            f"Une liste, un tuple ou une chaîne ne se multiplie pas par {describe_type(kind)} : np.array(…) en fait un "
            "tableau, dont le produit se fait terme à terme."
        )
    if kind == "NoneType":
        return f"« * » ne s’applique pas à None : {OR_NONE}"
    return (
        "Une liste, un tuple ou une chaîne ne se multiplie pas par un nombre à virgule : np.array(…) en fait un "
        "tableau "
        "(et « 0,5 » fait deux nombres : 0.5)."
    )


def _explain_ufunc(match: re.Match[str], source: str) -> str:
    name = match[1]
    if name == "bitwise_xor":
        return _power(source)
    if name in _LOGICAL:
        return (
            f"« {_LOGICAL[name]} » ne s’applique qu’à des vrais et des faux, ou à des entiers : entre comparaisons, "
            "chacune va entre parenthèses, (a > 0) & (b > 0)."
        )
    written = _OPERATORS.get(name, name)
    what = written if written in source else called_function(source) or name
    return (
        f"« {what} » ne s’applique qu’à des nombres : une chaîne de caractères, None ou une liste s’y trouve-t-elle ?"
    )


_LOGICAL = {"bitwise_and": "&", "bitwise_or": "|", "invert": "~", "left_shift": "<<", "right_shift": ">>"}
_OPERATORS = {
    "add": "+",
    "subtract": "-",
    "multiply": "*",
    "divide": "/",
    "power": "**",
    "remainder": "%",
    "floor_divide": "//",
    "matmul": "@",
    "less": "<",
    "less_equal": "<=",
    "greater": ">",
    "greater_equal": ">=",
}


def _explain_object_ufunc(match: re.Match[str], source: str) -> str:
    if match[1] == "NoneType":
        return f"np.{match[2]} reçoit None : {OR_NONE}"
    return (
        f"np.{match[2]} ne calcule pas sur un tableau d’objets (dtype=object) : une de ses cases est-elle None, une "
        f"liste "
        "ou une chaîne de caractères ?"
    )


def _explain_cast(match: re.Match[str], source: str) -> str:
    kinds = {
        "complex128": "complexes",
        "float64": "à virgule",
        "float32": "à virgule",
        "int64": "entiers",
        "bool": "booléens",
    }
    given, array = (kinds.get(kind, f"de type {kind}") for kind in match.groups())
    return (
        f"Un calcul sur place (+=, *=…) ne change pas le type du tableau : ses nombres sont {array}, et le résultat "
        f"en a "
        f"d’autres ({given}). Écrivez a = a + …, ou créez-le avec dtype=float."
    )


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
    return _wrong_count(function, takes, given)


def _wrong_count(function: str, takes: str, given: str) -> str:
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
    return f"Il manque à l’appel de {function} : {written}."


def _explain_unpacking(match: re.Match[str], source: str) -> str:
    return (
        f"À gauche du signe « = », {plural(match[1], 'nom')} ; à droite, "
        f"{(match[2] and plural(match[2], 'valeur')) or 'plus de valeurs'}."
    )


def _explain_iterated(match: re.Match[str], source: str) -> str:
    kind = match[1] or "float"
    loop = re.search(r"\bin\s+(?:len\((\w+)\)|(\d+|\w+))\s*[:\])]", source)
    if kind == "int" and loop and "for" in source:
        count = f"len({loop[1]})" if loop[1] else loop[2]
        return f"Une boucle parcourt plusieurs valeurs, et {count} est un nombre entier : range({count}) ?"
    return f"Il faut ici plusieurs valeurs (une liste, un tableau), et c’est {describe_type(kind)}."


def _explain_subscripted(match: re.Match[str], source: str) -> str:
    kind = match[1]
    if kind in CALLABLE_TYPES:
        return "Une fonction s’appelle avec des parenthèses, f(x), et non des crochets."
    if kind in ("generator", "map", "filter", "zip", "dict_keys", "dict_values", "dict_items", "set", "frozenset"):
        return f"{capitalise(describe_type(kind))} ne se lit pas avec des crochets : list(…) en fait une liste."
    return f"{capitalise(describe_type(kind))} n’a pas d’éléments : il ne se lit pas avec des crochets."


def _explain_assigned(match: re.Match[str], source: str) -> str:
    kind = match[1]
    if kind == "NoneType":
        return f"Cette valeur est None, sans éléments à changer : {OR_NONE}"
    if kind == "tuple":
        return "Un tuple ne change jamais : une liste, [..], ou un tableau changent d’éléments."
    if kind in ("str", "range"):
        return (
            f"{capitalise(describe_type(kind))} ne change jamais : il faut en faire une liste, ou en construire "
            f"une autre."
        )
    return f"{capitalise(describe_type(kind))} n’a pas d’éléments à changer."


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


def _explain_hash(match: re.Match[str], source: str) -> str:
    written = "tuple(a.tolist())" if "ndarray" in match[1] else "tuple(…)"
    return (
        f"{capitalise(describe_type(match[1]))} ne peut être ni une clé de dictionnaire, ni un élément d’ensemble : "
        f"{written} le peut, car un tuple ne change pas."
    )


def _explain_concatenation(match: re.Match[str], source: str) -> str:
    kinds = match.groups()
    cure = (
        "str(…) fait d’un nombre une chaîne, float(…) l’inverse"
        if "str" in kinds
        else "np.array(…) fait d’une liste un tableau"
    )
    if "NoneType" in kinds:
        return f"« + » ne s’applique pas à None : {OR_NONE}"
    return f"« + » ne s’applique pas entre {describe_type(kinds[0])} et {describe_type(kinds[1])} ; {cure}."


#: Texts of Python and numpy about types and calls, and what explains them; the first that matches counts.
_PATTERNS: tuple[Pattern, ...] = (
    (r"unsupported operand type\(s\) for (\S+(?: or \S+)?): '([\w.]+)' and '([\w.]+)'", _explain_operator),
    (r"'(\S+)' not supported between instances of '([\w.]+)' and '([\w.]+)'", _explain_comparison),
    (r"bad operand type for (unary .|[^:]+): '([\w.]+)'", _explain_sign),
    (
        r"loop of ufunc does not support argument \d+ of type ([\w.]+) which has no callable (\w+)",
        _explain_object_ufunc,
    ),
    (r"^ufunc '(\w+)' (?:did not contain a loop|not supported for the input)", _explain_ufunc),
    (
        r"Cannot cast ufunc '\w+' output from dtype\('(\w+)'\) to dtype\('(\w+)'\)",
        _explain_cast,
    ),
    (
        r"Cannot cast",
        told("Ces valeurs ne se convertissent pas en nombres : une chaîne de caractères s’y trouve-t-elle ?"),
    ),
    (
        r"the resolved dtypes are not compatible with|could not be promoted|no common DType",
        told(
            "Ce calcul ne s’applique qu’à des nombres, et une chaîne de caractères s’y trouve : float(…) lit le "
            "nombre qu’elle écrit."
        ),
    ),
    (r"can't multiply sequence by non-int of type '([\w.]+)'", _explain_product),
    (r'can only concatenate (\w+) \(not "([\w.]+)"\) to', _explain_concatenation),
    (r"only 0-dimensional arrays can be converted|only (?:length|size)-1 arrays can be converted", _explain_one_number),
    (
        r"can only convert an array of size 1 to a Python scalar",
        told("a.item() donne l’élément d’un tableau qui n’en a qu’un, et celui-ci en a plusieurs : a[0] ?"),
    ),
    (
        r"'[\w.]+' object cannot be interpreted as an integer|expected a sequence of integers or a single integer|"
        r"non-integer (?:stop|arg|step|start)",
        told("Il faut ici un nombre entier : int(…), ou // pour une division entière."),
    ),
    (r"'NoneType' object is not (?:subscriptable|iterable)", told(f"Cette valeur est None : {OR_NONE}")),
    (r"cannot unpack non-iterable NoneType", told(f"Cette valeur est None : {OR_NONE}")),
    (r"'([\w.]+)' object is not subscriptable", _explain_subscripted),
    (
        r"cannot unpack non-iterable ([\w.]+) object",
        said("Plusieurs noms attendent ici plusieurs valeurs (une liste, un tableau), et c’est {0}."),
    ),
    (r"'([\w.]+)' object is not iterable|iteration over a (0)-d array", _explain_iterated),
    (r"'([\w.]+)' object is not callable", _explain_call),
    (
        r"'([\w.]+)' object is not an iterator",
        said(
            "next(…) attend un itérateur, et c’est {0} : iter(…) en fait un, l[0] donne le premier élément d’une liste."
        ),
    ),
    (r"'([\w.]+)' object is not reversible", said("reversed(…) parcourt une liste à l’envers, et c’est {0}.")),
    (
        r"object of type '([\w.]+)' has no len\(\)|len\(\) of unsized object",
        lambda match, source: (
            f"len(…) compte les éléments d’une liste ou d’un tableau, et c’est {describe_type(match[1] or 'float')}."
            + (" list(…) en fait une liste." if match[1] in ("generator", "map", "filter", "zip") else "")
        ),
    ),
    (r"'([\w.]+)' object does(?: not|n't) support item (?:assignment|deletion)", _explain_assigned),
    (
        r"'([\w.]+)' object does not support the (?:asynchronous )?context manager protocol",
        said("« with » s’emploie avec un fichier ouvert ou un verrou, et c’est {0}."),
    ),
    (
        r"type (\w+) doesn't define __(\w+)__ method",
        lambda match, source: (
            f"{match[2]}(…) attend un nombre, et reçoit {describe_type(match[1])}"
            + (" : np.round(…) arrondit tous les éléments." if match[1] in ("list", "tuple") else ".")
        ),
    ),
    (r"\w+\(\) argument must be a (?:string|.*real number).*, not '([\w.]+)'", _explain_real),
    (r"must be real number, not ([\w.]+)|a real number is required, not ([\w.]+)", _explain_real),
    (r"unhashable type: '([\w.]+)'", _explain_hash),
    (
        r"truth value of an (?:array|empty array)",
        lambda match, source: (
            "Un tableau vide n’est ni vrai ni faux : a.size > 0 dit s’il a des éléments."
            if "empty" in match[0]
            else "Un tableau de plusieurs éléments n’est ni vrai ni faux : (…).all() s’ils doivent l’être tous, "
            "(…).any() "
            "si un seul suffit ; « & » et « | » remplacent « and » et « or » entre tableaux."
        ),
    ),
    (r"Unable to avoid copy", told("Depuis NumPy 2, np.array(…, copy=False) s’écrit np.asarray(…).")),
    (
        r"Calling np\.sum\(generator\)",
        told("np.sum ne prend plus de générateur : np.sum([…]) avec des crochets, ou sum(…) de Python."),
    ),
    (
        r"Python integer (-?\d+) out of bounds for (\w+)",
        told("Depuis NumPy 2, {0} n’est plus converti : il sort de {1}."),
    ),
    (
        r"Cannot interpret '(.*)' as a data type|Field elements must be",
        told("La forme d’un tableau se donne en un seul argument, entre parenthèses : np.zeros((2, 3))."),
    ),
    (r"data type '?(.+?)'? not understood", told("Le type « {0} » n’existe pas : dtype=float, int ou bool.")),
    # Methods of a class of the student's: the object is an argument.
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
        lambda match, source: _wrong_count(
            called_function(source) if match[1] == "function" else match[1],
            {"one": "1", "no": "0"}.get(match[2], match[2]),
            match[3],
        ),
    ),
    (r"^(?:[\w.]+\.)?(\w+)\(\) takes no (?:keyword )?arguments", told("« {0} » ne prend pas cet argument.")),
    (r"^([\w.<>]+)\(\) missing \d+ required (?:positional|keyword-only) arguments?: (.*)", _explain_missing),
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
    (r"not enough values to unpack \(expected (?:at least )?(\d+), got (\d+)\)", _explain_unpacking),
    (r"too many values to unpack \(expected (\d+)()", _explain_unpacking),
    (
        r"exceptions must derive from BaseException",
        told('« raise » lève une exception : raise ValueError("le message"), et non une chaîne ou un nombre.'),
    ),
    (
        r"(isinstance|issubclass)\(\) arg (\d) must be",
        told("{0}(…) attend un type, comme float ou np.ndarray, ou un tuple de types."),
    ),
)
