"""Files that Python cannot read: its texts about them, in French."""

from __future__ import annotations

import re

from server.sandbox.explanations.guilty_lines import (
    STRINGS,
    UNKNOWN,
    explain_colon,
    explain_decimal,
    explain_invalid,
    explain_missing,
)
from server.sandbox.explanations.patterns import Pattern, first_sentence, told


def _explain_name(match: re.Match[str], source: str) -> str:
    return f"« {match[1]} » est une constante de Python, et ne reçoit pas de valeur"


#: Texts of Python's parser and what explains them; the first that matches counts.
_PATTERNS: tuple[Pattern, ...] = (
    (r"^expected ':'", explain_colon),
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
            explain_missing(STRINGS.sub('""', source))
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
    (r"^invalid (?:decimal|imaginary) literal", explain_decimal),
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
    (r"^invalid syntax|.*", explain_invalid),
)


def explain_syntax(text: str, source: str) -> str:
    """Return what is wrong with a line that Python cannot read, in French, without a full stop.

    `text` is Python's; `source` is the line, empty where it is unknown.
    """
    return first_sentence(_PATTERNS, text.removeprefix("f-string: "), source) or UNKNOWN
