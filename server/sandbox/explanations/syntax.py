"""Files that Python cannot read: its texts about them in French, and what the guilty line shows where it says "
"little."""

from __future__ import annotations

import keyword
import re

from server.sandbox.explanations.patterns import Pattern, first_sentence, told

_UNKNOWN = "Python ne comprend pas cette ligne (regardez aussi la fin de la précédente)"
_STRINGS = re.compile(r"\"[^\"]*\"|'[^']*'|#.*")
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


def _explain_invalid(match: re.Match[str], source: str) -> str:
    """Return what the guilty line shows: Python itself only says « invalid syntax »."""
    code = _STRINGS.sub(lambda it: "#" if it[0][0] == "#" else '""', source).split("#", 1)[0].strip()
    for explain in (_explain_reserved, _explain_foreign_word, _explain_operator, _explain_missing):
        if sentence := explain(code):
            return sentence
    return _UNKNOWN


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


def _explain_missing(code: str) -> str | None:
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


def _explain_decimal(match: re.Match[str], source: str) -> str:
    code = _STRINGS.sub('""', source)
    if function := re.match(r"\s*(?:def|class)\s+(\d\w*)", code):
        return f"un nom ne commence pas par un chiffre : « {function[1]} »"
    found = _NUMBER_NAME.search(code)
    if found and not re.fullmatch(r"[eE]\d*", found[2]) and "_" not in found[2][:1]:
        assigned = re.match(rf"\s*{re.escape(found[0])}\s*=(?!=)", code)
        if assigned:
            return f"un nom ne commence pas par un chiffre : « {found[0]} »"
        return _missing_product(found[1], found[2])
    return "ce nombre est mal écrit"


def _explain_colon(match: re.Match[str], source: str) -> str:
    code = _STRINGS.sub('""', source).split("#", 1)[0].strip()
    if re.match(r"else\s+if\b", code):
        return "« else if » s’écrit « elif » en Python"
    if code.endswith("{"):
        return "Python n’a pas d’accolades : « : » à la fin de cette ligne, et ce qui suit décalé à droite"
    if (operator := _explain_operator(code)) and not code.endswith(":"):
        return operator
    if re.search(r"[^=!<>]=(?!=)", code) and re.match(r"(?:el)?if\b|while\b", code):
        return "« = » affecte une valeur ; pour comparer, écrivez « == »"
    if code.endswith(":"):
        return f"{_UNKNOWN} : un signe ou un mot manque avant « : »"
    return "il manque « : » à la fin de cette ligne"


def _explain_name(match: re.Match[str], source: str) -> str:
    return f"« {match[1]} » est une constante de Python, et ne reçoit pas de valeur"


#: Texts of Python's parser and what explains them; the first that matches counts.
_PATTERNS: tuple[Pattern, ...] = (
    (r"^expected ':'", _explain_colon),
    (r"^'(.+)' was never closed", told("« {0} » est ouvert ici et n’est jamais refermé")),
    (r"^unmatched '(.+)'", told("« {0} » ferme ce qui n’a pas été ouvert")),
    (
        r"^closing parenthesis '(.)' does not match opening parenthesis '(.)'(?: on line (\d+))?",
        lambda match, source: (
            f"« {match[1]} » ferme « {match[2]} »{f', ouvert ligne {match[3]}' if match[3] else ''} : les deux ne vont "
            "pas ensemble"
        ),
    ),
    (
        r"^expected an indented block after (.+) on line (\d+)",
        lambda match, source: (
            f"ce qui suit la ligne {match[2]} doit être décalé à droite (une fonction vide s’écrit avec « pass »)"
            if "function" in match[1]
            else f"ce qui suit la ligne {match[2]} doit être décalé à droite"
        ),
    ),
    (r"^unexpected indent", told("cette ligne est décalée vers la droite sans raison")),
    (r"^unindent does not match", told("le décalage de cette ligne ne correspond à aucun bloc ouvert au-dessus")),
    (r"^inconsistent use of tabs", told("des tabulations et des espaces sont mélangés pour décaler les lignes")),
    (r"^too many levels of indentation", told("trop de niveaux imbriqués")),
    (
        r"^unterminated (?:triple-quoted )?f?-?(?:string|f-string)",
        lambda match, source: (
            'une apostrophe dans une chaîne entre apostrophes la ferme : entourez-la de guillemets "'
            if re.search(r"'\w*'\w", source)
            else "il manque le guillemet qui ferme cette chaîne"
        ),
    ),
    (
        r"^cannot assign to (?:expression|literal|function call|comparison|conditional expression) here",
        told("« = » range la valeur de droite dans ce qui est à gauche, un nom ; pour comparer, écrivez « == »"),
    ),
    (r"Maybe you meant '==' ", told("« = » affecte une valeur ; pour comparer, écrivez « == »")),
    (r"^cannot assign to (None|True|False|__debug__|Ellipsis)", _explain_name),
    (r"^cannot assign to attribute here", told("« = » affecte une valeur ; pour comparer, écrivez « == »")),
    (
        r"^(?:cannot assign to|cannot delete|'.*' is an illegal expression for) ?(?:function call)",
        told("le résultat d’un appel n’est pas un nom : à gauche de « = » se trouve ce qui reçoit la valeur"),
    ),
    (
        r"^cannot (?:assign to|delete|use assignment expressions with)|illegal (?:target|expression) for|"
        r"only single target",
        told("à gauche de « = » se trouve ce qui reçoit la valeur : un nom, un élément a[i] ou un attribut"),
    ),
    (
        r"^expression cannot contain assignment",
        told("« nom=valeur » donne un argument par son nom ; pour comparer, écrivez « == »"),
    ),
    (
        r"Perhaps you forgot a comma",
        lambda match, source: (
            _explain_missing(_STRINGS.sub('""', source))
            or "il manque peut-être une virgule, ou un signe entre deux valeurs"
        ),
    ),
    (
        r"invalid non-printable character (U\+\w+)",
        told("un caractère invisible ({0}) n’a rien à faire là (copier-coller ?)"),
    ),
    (r"invalid character '(.+)' \((U\+\w+)\)", told("le caractère « {0} » n’existe pas en Python (copier-coller ?)")),
    (
        r"^'(return|yield|await|yield from|async \w+)' (?:outside|only allowed)",
        told("« {0} » n’a de sens que dans une fonction"),
    ),
    (r"^asynchronous|^'await'", told("« async » et « await » n’ont pas leur place ici")),
    (r"^'(break|continue)' ", told("« {0} » n’a de sens que dans une boucle")),
    (r"^positional argument follows keyword argument", told("un argument sans nom suit un argument nommé")),
    (r"^iterable argument unpacking follows", told("« *liste » se met avant « **dictionnaire »")),
    (r"^keyword argument repeated(?:: (\w+))?", lambda match, source: f"l’argument « {match[1]} » est donné deux fois"),
    (
        r"follows default argument|follows parameter with a default",
        told("un paramètre sans valeur par défaut en suit un qui en a une"),
    ),
    (r"^duplicate argument '(.+)' in function", told("deux paramètres ont le même nom : « {0} »")),
    (r"^named (?:arguments|parameters) must follow bare \*", told("il faut des paramètres après « * »")),
    (r"^expected '\('", told("le nom d’une fonction est suivi de ses paramètres entre parenthèses : def f(x):")),
    (r"^expected 'except' or 'finally' block", told("« try » est suivi d’un « except » de même décalage")),
    (r"^default 'except:' must be last", told("« except » sans type vient en dernier")),
    (
        r"^multiple exception types must be parenthesized",
        told("plusieurs exceptions vont entre parenthèses : except (A, B):"),
    ),
    (
        r"^Generator expression must be parenthesized",
        told("un générateur suivi d’autres arguments va entre parenthèses"),
    ),
    (
        r"^did you forget parentheses around the comprehension target",
        told("for a, b s’écrit (a, b) au début : [(a, b) for …]"),
    ),
    (r"':' expected after dictionary key", told("il manque « : » et une valeur après une clé du dictionnaire")),
    (r"expression expected after dictionary key", told("il manque une valeur après une clé du dictionnaire")),
    (r"^expected 'else' after 'if' expression", told("« a if c » demande un « else » : a if c else b")),
    (r"^import \* only allowed at module level", told("« import * » se met en tête du fichier, hors des fonctions")),
    (r"^trailing comma not allowed", told("une virgule est de trop à la fin de l’import")),
    (
        r"^name '(.+)' is (?:used|assigned to) (?:prior to|before) (global|nonlocal)",
        told("« {1} {0} » vient avant tout emploi de ce nom dans la fonction"),
    ),
    (
        r"^name '(.+)' is parameter and (?:global|nonlocal)",
        told("« {0} » est un paramètre de la fonction : il n’est pas global"),
    ),
    (
        r"^nonlocal declaration not allowed|^no binding for nonlocal",
        told("« nonlocal » désigne une variable d’une fonction qui en contient une autre"),
    ),
    (
        r"starred expression|starred assignment target|can't use starred|unparenthesized star",
        told("« *… » n’a pas sa place ici : pour multiplier, il manque ce qui précède « * »"),
    ),
    (r"^illegal expression for augmented|augmented assignment", told("« += » change un seul nom à la fois")),
    (r"^(?:'.*'|.*) is an illegal expression for augmented", told("« += » change un seul nom à la fois")),
    (r"annotated|annotation", told("l’annotation (« : type ») n’a pas sa place ici")),
    (
        r"^\(unicode error\) 'unicodeescape'",
        told("une barre oblique inverse annonce un caractère spécial dans cette chaîne : doublez-la, \\\\"),
    ),
    (
        r"^(?:unknown encoding|encoding problem): (\S+?)(?: with BOM)?$",
        told("l’encodage « {0} », écrit en tête du fichier, n’existe pas : retirez cette ligne, ou écrivez « utf-8 »"),
    ),
    (
        r"codec can't decode|Non-UTF-8 code",
        told("le fichier n’est pas enregistré en UTF-8 : enregistrez-le de nouveau dans cet encodage"),
    ),
    (r"^bytes can only contain ASCII", told("b'…' ne prend que des lettres sans accent")),
    (r"^cannot mix bytes and nonbytes", told("b'…' ne se joint pas à une autre chaîne")),
    (r"too many nested parentheses|too many statically nested", told("trop de niveaux imbriqués")),
    (r"maximum recursion depth exceeded|parser stack overflow", told("l’expression est trop profondément imbriquée")),
    (r"^leading zeros in decimal", told("un nombre entier ne commence pas par 0")),
    (r"^invalid (?:decimal|imaginary) literal", _explain_decimal),
    (r"^invalid (?:hexadecimal|octal|binary) literal|^invalid digit '(.)' in", told("ce nombre est mal écrit")),
    (
        r"^Missing parentheses in call to '(\w+)'",
        told("« {0} » est une fonction : ses arguments vont entre parenthèses"),
    ),
    (r"expecting '}'", told('il manque « }} » dans cette chaîne f"…"')),
    (r"single '}' is not allowed", told('« }} » est seul dans cette chaîne f"…" : « }}}} » l’écrit')),
    (
        r"empty expression not allowed|valid expression required",
        told('les accolades d’une chaîne f"…" contiennent une valeur : f"{{x}}"'),
    ),
    (r"invalid conversion character|conversion type", told('après « ! », une chaîne f"…" n’accepte que s, r ou a')),
    (
        r"expressions nested too deeply|cannot include a backslash|backslash",
        told('une barre oblique inverse n’a pas sa place dans les accolades d’une chaîne f"…"'),
    ),
    (
        r"^unexpected character after line continuation",
        told(
            "après « \\ », la ligne doit finir là, sans espace ni commentaire : cette barre continue la ligne sur "
            "la suivante"
        ),
    ),
    (r"^unexpected EOF|^unexpected end of file", told("le fichier s’arrête avant la fin de cette instruction")),
    (
        r"^assignment expression|cannot use (?:named )?assignment",
        told("« := » n’a pas sa place ici : « = » affecte une valeur"),
    ),
    (r"^invalid syntax|.*", _explain_invalid),
)


def explain_syntax(text: str, source: str) -> str:
    """Return what is wrong with a line that Python cannot read, in French, without a full stop.

    `text` is Python's; `source` is the line, empty where it is unknown.
    """
    return first_sentence(_PATTERNS, text.removeprefix("f-string: "), source) or _UNKNOWN
