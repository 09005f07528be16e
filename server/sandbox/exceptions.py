"""Exceptions of a student's program in French: explained by their text, else by what their type means."""

from __future__ import annotations

import re
from collections.abc import Sequence

from server.sandbox.explanations import explain_error, with_values
from server.sandbox.faults import Frame

_ADVICE = {
    "NameError": "Ce nom n’est défini nulle part : faute de frappe, ou définition oubliée ?",
    "UnboundLocalError": "Cette variable est lue avant d’avoir reçu une valeur dans la fonction.",
    "TypeError": "Une valeur n’a pas le type qui convient, ou un appel n’a pas le bon nombre d’arguments.",
    "IndexError": "Un indice ne désigne aucun élément : ils vont de 0 à la longueur moins un.",
    "UFuncTypeError": "Ce calcul de numpy ne s’applique pas à des valeurs de ce type.",
    "AxisError": "Cet axe n’existe pas : un tableau a autant d’axes que de dimensions, numérotés à partir de 0.",
    "Exception": "Une exception a arrêté votre programme à cette ligne.",
    "RuntimeError": "Un appel n’est pas possible à cet endroit du programme.",
    "KeyError": "Cette clé n’est pas dans le dictionnaire.",
    "AttributeError": "Cet objet n’a pas d’attribut ni de méthode de ce nom.",
    "ZeroDivisionError": "Un diviseur est nul.",
    "RecursionError": "Une fonction s’appelle elle-même sans fin : quel cas doit l’arrêter ?",
    "ValueError": "Une valeur ne convient pas ; avec numpy, vérifiez les dimensions (« shape ») de vos tableaux.",
    "LinAlgError": "Le calcul matriciel est impossible : la matrice est peut-être singulière.",
    "EOFError": "Rien ne peut être lu au clavier ici : n’utilisez pas « input ».",
    "SystemExit": "« exit » arrête tout le programme : utilisez « return » pour sortir d’une fonction.",
    "FileNotFoundError": "Aucun fichier de données n’est fourni : tout arrive par les arguments.",
    "AssertionError": "Une assertion est fausse : la vôtre, ou celle d’une bibliothèque qui refuse votre valeur.",
    "NotImplementedError": "Cette fonction reste à écrire.",
    "OverflowError": "Un nombre est devenu trop grand : cherchez une division par presque zéro, ou une exponentielle.",
    "FloatingPointError": "Un calcul sort des nombres que la machine peut écrire.",
    "StopIteration": "Un itérateur est épuisé : « next » n’a plus rien à donner.",
    "BrokenPipeError": "Personne ne lit à l’autre bout : tout arrive par les arguments, tout repart par « return ».",
    "KeyboardInterrupt": "Votre programme a demandé à être interrompu.",
}  # fmt: skip


#: What the names of errors mean that a student meets, for a glossary: those of reading a file first.
USUAL_ERRORS = {
    "SyntaxError": (
        "Python ne peut pas lire cette ligne : il manque souvent deux points, une parenthèse ou un guillemet, ici ou à "
        "la fin de la ligne d’avant."
    ),
    "IndentationError": (
        "Cette ligne n’est pas décalée comme elle le devrait : quatre espaces sous une ligne qui finit par « : », et "
        "le même décalage pour toutes les lignes d’un bloc."
    ),
    **{
        name: _ADVICE[name]
        for name in (
            *("NameError", "UnboundLocalError", "TypeError", "IndexError", "KeyError", "AttributeError", "ValueError"),
            *("ZeroDivisionError", "RecursionError", "LinAlgError", "AxisError", "OverflowError", "AssertionError"),
            *("NotImplementedError", "FileNotFoundError", "EOFError"),
        )
    },
}


#: Advice for system errors, by the words of their text (`OSError` alone says little).
_SYSTEM = {
    "Too many open files": "Trop de fichiers sont ouverts à la fois : fermez-les, ou ouvrez-les par « with ».",
    "No space left on device": "Votre dossier est plein : n’y gardez que le nécessaire, ou calculez sans fichier.",
    "Disk quota exceeded": "Votre dossier est plein : n’y gardez que le nécessaire, ou calculez sans fichier.",
    "File too large": "Ce fichier est trop gros : calculez sans fichier, ou écrivez moins.",
}


#: Words of a French text.
_FRENCH = re.compile(
    r"\b(?:les?|la|une?|des?|du|est|sont|pas|ne|sans|et|ou|dans|pour|par)\b|[àâçéèêîôùû’«]", re.IGNORECASE
)


#: Words of the `input` of exercises that give lines to read, after the last.
_LINES_OVER = "plus de ligne à lire"


#: Statements by which a program raises an exception itself, with words of its own.
_OWN = re.compile(r"(?:^|[;:]\s*)(?:raise|assert)\b")


_WITH_VALUES = ("TypeError", "ValueError", "IndexError", "LinAlgError", "UFuncTypeError", "AxisError")


_FAMILIES = {
    "UnicodeEncodeError": "Ce texte ne s’écrit pas dans cet encodage : UTF-8 connaît tous les caractères.",
    "UnicodeDecodeError": "Ces octets ne sont pas un texte dans cet encodage.",
    "SyntaxError": "Le texte donné à « eval » ou « exec » n’est pas du Python.",
    "IndentationError": "Le texte donné à « eval » ou « exec » n’est pas du Python.",
    "StopAsyncIteration": "Un itérateur est épuisé.",
    "LookupError": "Ce qui est cherché n’existe pas.",
    "ArithmeticError": "Un calcul est impossible.",
    "TypeError": "Une valeur n’a pas le type qui convient, ou un appel n’a pas le bon nombre d’arguments.",
    "OSError": "Le système refuse cette opération : tout arrive par les arguments, tout repart par « return ».",
    "RuntimeError": "Un appel n’est pas possible à cet endroit du programme.",
    "Warning": "Un avertissement arrête ici le programme : il a été changé en exception.",
}


def describe_exception(
    exception: str, text: str, frames: Sequence[Frame], values: str = "", file_lines: Sequence[str] = ()
) -> str:
    """Return the sentence of an exception; `values` tells the names on its line, `file_lines` are the file's.

    It ends with the type of the exception, the only word of Python's that it keeps: its texts are in English. A text
    that the student's own program wrote is theirs, and is shown.
    """
    source = frames[-1].source if frames else ""
    system = next((advice for words, advice in _SYSTEM.items() if words in text), None)
    if system is None and _OWN.search(source) and not _is_message_of_python(exception, text):
        return f"{_describe_student_exception(exception, text)} [{exception}]"
    sentence = explain_error(exception, text, values, frames, file_lines) if text else None
    if sentence is None:
        advice = (
            system or _special_advice(exception, text) or _ADVICE.get(exception) or _explain_by_name_ending(exception)
        )
        if system is None and _FRENCH.search(text):  # a function of the course, or the program's own
            advice = f"« {text.splitlines()[0]} ». {advice}"
        # Some exceptions have a name or a path where others have values.
        sentence = with_values(advice, values if exception in _WITH_VALUES else "")
    return f"{sentence} [{exception}]"


def _is_message_of_python(exception: str, text: str) -> bool:
    """Whether the text is Python's own, about the statement that raises: « raise 3 », « raise ValuError »."""
    return (exception == "TypeError" and text.startswith("exceptions must")) or (
        exception == "NameError" and text.startswith("name '")
    )


def _describe_student_exception(exception: str, text: str) -> str:
    """Return the sentence of an exception that the program raised itself."""
    if exception == "NotImplementedError":
        return f"Cette fonction reste à écrire{f' (« {text} »)' if text else ''}."
    if exception == "AssertionError":
        return f"Une assertion de votre programme est fausse{f' : « {text} »' if text else ''}."
    if exception == "KeyboardInterrupt":
        return f"{_ADVICE[exception]}"
    said = f" : « {text} »" if text else ""
    return f"Votre programme lève lui-même cette exception{said}."


def _special_advice(exception: str, text: str) -> str | None:
    """Return the advice for an exception whose text holds a value: a key, a path; or says that typed lines ran out."""
    if exception == "EOFError" and _LINES_OVER in text:
        return "« input » est appelé plus de fois qu’il n’y a de lignes."
    if exception == "KeyError" and text:
        return f"La clé {text.splitlines()[0][:80]} n’est pas dans le dictionnaire : d.get(…) donne None à sa place."
    if exception == "FileNotFoundError" and (
        path := re.search(r"'([^']*)'", text) or re.match(r"(\S+) not found", text)
    ):
        return f"Le fichier « {path[1]} » n’existe pas ici. {_ADVICE[exception]}"
    return None


def _explain_by_name_ending(exception: str) -> str:
    """Return what an exception without advice of its own means, by the end of its name."""
    for end, advice in _FAMILIES.items():
        if exception.endswith(end):
            return advice
    return f"Une exception de type « {exception} » a arrêté votre programme à cette ligne."
