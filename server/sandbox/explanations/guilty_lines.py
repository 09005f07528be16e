"""What a line shows that Python cannot read, where Python itself says little: « invalid syntax »."""

from __future__ import annotations

import keyword
import re

from server.sandbox.explanations.patterns import Pattern, first_sentence, told

UNKNOWN = "Python ne comprend pas cette ligne (regardez aussi la fin de la précédente)"


STRINGS = re.compile(r"\"[^\"]*\"|'[^']*'|#.*")


#: Words of a formula in French or of another language, and those of Python.
_WORDS = {
    "si": "if",
    "sinon": "else",
    "sinonsi": "elif",
    "elsif": "elif",
    "elseif": "elif",
    "pour": "for",
    "tantque": "while",
    "tant": "while",
    "retourner": "return",
    "retourne": "return",
    "retour": "return",
    "renvoyer": "return",
    "renvoie": "return",
    "rendre": "return",
    "fonction": "def",
    "function": "def",
    "define": "def",
    "func": "def",
    "definir": "def",
    "définir": "def",
    "classe": "class",
    "importer": "import",
    "include": "import",
    "using": "import",
    "depuis": "from",
    "afficher": "print",
    "var": "",
    "let": "",
    "const": "",
    "int": "",
    "float": "",
    "double": "",
}


_OPERATORS = (
    (r"&&", "« && » s’écrit « and » en Python"),
    (r"\|\|", "« || » s’écrit « or » en Python"),
    (r"=<", "« =< » s’écrit « <= » en Python"),
    (r"=>", "« => » s’écrit « >= » en Python"),
    (r"<>", "« <> » s’écrit « != » en Python"),
    (r"=\s+=", "« = = » s’écrit « == », sans espace, pour comparer ; un seul « = » affecte une valeur"),
    (r"!(?!=)", "« ! » s’écrit « not » en Python"),
    (r"\+\+", "« ++ » n’existe pas en Python : x += 1"),
    (r"--\s*$", "« -- » n’existe pas en Python : x -= 1"),
    (r"\?.*:", "« c ? a : b » s’écrit « a if c else b » en Python"),
    (r"\?", "« ? » n’existe pas en Python"),
    (r"\$", "« $ » n’existe pas en Python"),
    (r"`", "« ` » n’existe pas en Python : une chaîne va entre guillemets \" ou '"),
    (r"\bthen\b|\balors\b", "Python n’a pas de « then » : « if … : », puis un retour à la ligne"),
)


_NUMBER_NAME = re.compile(r"(?<![\w.])(\d+\.?\d*|\.\d+)\s*([^\W\d]\w*)")


_TWO_NAMES = re.compile(r"(?<![\w.])([^\W\d]\w*)\s+([^\W\d]\w*|\d[\d.]*)")


_ASSIGNED_WORD = re.compile(r"(?:^|[(,]|\bfor )\s*([a-z]+)\s*(?=[=,)]|\bin\b)")


_NAMED = re.compile(r"^\s*(?:def|class)\s+([A-Za-z]+)\b|\.([a-z]+)\b")


_FOLLOWED = ("if", "else", "elif", "for", "while", "in", "is", "not", "and", "or", "lambda", "return", "as", "import")


def explain_invalid(match: re.Match[str], source: str) -> str:
    """Return what the guilty line shows: Python itself only says « invalid syntax »."""
    code = STRINGS.sub(lambda it: "#" if it[0][0] == "#" else '""', source).split("#", 1)[0].strip()
    for explain in (_explain_reserved, _explain_foreign_word, _explain_operator, explain_missing):
        if sentence := explain(code):
            return sentence
    return UNKNOWN


def _explain_reserved(code: str) -> str | None:
    """« lambda = 3 »: a word that Python keeps for itself cannot be a name."""
    names = [it[1] for it in _ASSIGNED_WORD.finditer(code)] + [it[1] or it[2] for it in _NAMED.finditer(code)]
    name = next((name for name in names if keyword.iskeyword(name) and name not in ("None", "True", "False")), None)
    if name in ("else", "elif", "except", "finally") or (name in ("import", "from") and "=" not in code):
        return None
    return f"« {name} » est un mot réservé de Python : prenez un autre nom, comme « {name}_ »" if name else None


def _explain_foreign_word(code: str) -> str | None:
    first = re.match(r"[^\W\d]\w*", code)
    word = first[0].casefold() if first else ""
    if word == "else" and re.match(r"else\s+if\b", code):
        return "« else if » s’écrit « elif » en Python"
    if word in _WORDS and not re.match(r"\w+\s*[=(.\[+\-*/]", code):
        instead = _WORDS[word]
        if not instead:
            return f"Python ne déclare pas ses variables : retirez « {first[0] if first else word} »"
        return f"« {first[0] if first else word} » s’écrit « {instead} » en Python"
    if word in ("else", "elif", "except", "finally"):
        needs = "try" if word in ("except", "finally") else "if"
        return f"« {word} » ne suit aucun « {needs} » de même décalage"
    return None


def _explain_operator(code: str) -> str | None:
    return next((sentence for pattern, sentence in _OPERATORS if re.search(pattern, code)), None)


def explain_missing(code: str) -> str | None:
    return first_sentence(_MISSING, code, code) or _explain_neighbours(code) or first_sentence(_LEFT_OUT, code, code)


def _explain_neighbours(code: str) -> str | None:
    """« L 2 », « 2 x »: two values with nothing between them."""
    for match in _NUMBER_NAME.finditer(code):
        if match[2] not in _FOLLOWED:
            return _missing_product(match[1], match[2])
    for match in _TWO_NAMES.finditer(code):
        if not (keyword.iskeyword(match[1]) or keyword.iskeyword(match[2])):
            return f"« {match[1]} {match[2]} » : il manque un signe (*, +…) ou une virgule entre les deux"
    return None


#: What a line shows that Python only says not to understand: before two neighbouring values are looked for, and after.
_MISSING: tuple[Pattern, ...] = (
    (
        r"(?<![\w.])(\d{1,3}(?: \d{3})+)(?![\w.])",
        lambda match, source: f"un nombre s’écrit sans espace : {match[1].replace(' ', '')}",
    ),
    (r"(?<![\w.])(\d+\.\d+\.\d+)", told("« {0} » a deux points décimaux")),
    (
        r"^from\s+[\w.]+\s+(?!import\b)\w+",
        told("« from … import … » : le mot « import » manque"),
    ),
    (r"^for\b(?!.*\bin\b)", told("une boucle s’écrit « for i in … : » : le mot « in » manque")),
    (
        r"^(?:import|from)\b",
        told("un import s’écrit « import module », « import module as m » ou « from module import nom, autre »"),
    ),
)


_LEFT_OUT: tuple[Pattern, ...] = (
    (r",\s*,|[\[({]\s*,|^\s*,", told("une virgule est de trop : il n’y a rien entre elle et ce qui précède")),
    (
        r"(?:[-+*/%@=<>]|\b(?:and|or|not|in|is|if|else))\s*$",
        told("la ligne s’arrête avant la fin du calcul : il manque ce qui suit le dernier signe"),
    ),
    (r"\[\s*\]", told("des crochets vides ne désignent aucun élément : a[i]")),
    (r"\.\s*$|\.\.|\.\d", told("il manque un nom après le point")),
    (r"[-+*/%]\s*=\s*=|[+*/%-]{3,}", told("deux signes se suivent")),
)


def _missing_product(number: str, name: str) -> str:
    return f"il manque un signe « * » entre {number} et {name} : {number} * {name}"


def explain_decimal(match: re.Match[str], source: str) -> str:
    code = STRINGS.sub('""', source)
    if function := re.match(r"\s*(?:def|class)\s+(\d\w*)", code):
        return f"un nom ne commence pas par un chiffre : « {function[1]} »"
    found = _NUMBER_NAME.search(code)
    if found and not re.fullmatch(r"[eE]\d*", found[2]) and "_" not in found[2][:1]:
        assigned = re.match(rf"\s*{re.escape(found[0])}\s*=(?!=)", code)
        if assigned:
            return f"un nom ne commence pas par un chiffre : « {found[0]} »"
        return _missing_product(found[1], found[2])
    return "ce nombre est mal écrit"


def explain_colon(match: re.Match[str], source: str) -> str:
    code = STRINGS.sub('""', source).split("#", 1)[0].strip()
    if re.match(r"else\s+if\b", code):
        return "« else if » s’écrit « elif » en Python"
    if code.endswith("{"):
        return "Python n’a pas d’accolades : « : » à la fin de cette ligne, et ce qui suit décalé à droite"
    if (operator := _explain_operator(code)) and not code.endswith(":"):
        return operator
    if re.search(r"[^=!<>]=(?!=)", code) and re.match(r"(?:el)?if\b|while\b", code):
        return "« = » affecte une valeur ; pour comparer, écrivez « == »"
    if code.endswith(":"):
        return f"{UNKNOWN} : un signe ou un mot manque avant « : »"
    return "il manque « : » à la fin de cette ligne"
