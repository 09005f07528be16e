"""French messages of the faults: the event, its line, the limit, and advice."""

from __future__ import annotations

import difflib
import re
import signal
import sys
from collections.abc import Iterable, Sequence

from server.sandbox.child import drawing_stand_ins, library
from server.sandbox.exceptions import describe_exception
from server.sandbox.explanations import explain_import
from server.sandbox.explanations.syntax import explain_syntax
from server.sandbox.faults import Frame
from server.sandbox.foreign_characters import (
    describe_foreign_characters,
    find_foreign_characters,
    is_readable,
    replace_foreign_characters,
    show_foreign_characters,
)
from server.sandbox.piled_marks import MAX_MARKS
from server.sandbox.policy import GIB, KIB, MIB, Policy

_NO_BREAK_SPACE = "\u00a0"

_OF_A_CHARACTER = re.compile("invalid (non-printable )?character")
_LONGEST_LINE = 200


_SIGNALS = {
    signal.SIGSEGV: "il est sorti de sa mémoire, ou a débordé la pile (récursion trop profonde ?)",
    signal.SIGBUS: "il a accédé à une zone de mémoire qui n’existe pas",
    signal.SIGABRT: "une bibliothèque a interrompu le programme",
    signal.SIGFPE: "une opération arithmétique est impossible",
    signal.SIGILL: "le processeur a reçu une instruction qui n’existe pas",
}  # fmt: skip


def add_no_break_spaces(text: str) -> str:
    """Puts the no-break spaces of French typography."""
    text = re.sub(r" ([:;?!»])", _NO_BREAK_SPACE + r"\1", text)
    return text.replace("« ", "«" + _NO_BREAK_SPACE)


def remove_control_characters(text: str) -> str:
    """A student's text without control characters (they could act on a terminal or a page), line ends aside."""
    return "".join(c if c == "\n" or (c.isprintable() and not _is_bidi(c)) else "\ufffd" for c in text)


def _is_bidi(character: str) -> bool:
    return character in "\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069\u200e\u200f\u061c"


def format_byte_size(count: int) -> str:
    for unit, name in ((GIB, "Gio"), (MIB, "Mio"), (KIB, "Kio")):
        if count >= unit:
            return f"{count / unit:.4g} {name}".replace(".", ",")
    return f"{count} octets"


def format_seconds(duration: float) -> str:
    return f"{duration:.3g} s".replace(".", ",")


def prefix_with_line(line: int | None, frames: tuple[Frame, ...], sentence: str) -> str:
    """« Ligne 12, dans « f » (return a[3]) : … », or the sentence alone when the line is unknown."""
    if line is None:
        return sentence[:1].upper() + sentence[1:]
    inside = frames[-1] if frames else None
    where = f", dans « {inside.function} »" if inside and not inside.function.startswith("<") else ""
    source = f" ({inside.source[:80]})" if inside and inside.source else ""
    return f"Ligne {line}{where}{source} : {sentence}"


def syntax_error(text: str, source: str, line: int | None, lines: Sequence[str] = ()) -> str:
    """Return the sentence of a syntax error; `lines` are those of the file, where they are known."""
    foreign = find_foreign_characters(lines)
    if foreign and (_OF_A_CHARACTER.search(text) or is_readable(replace_foreign_characters(lines, foreign))):
        shown = show_foreign_characters(lines[line - 1].strip())[:_LONGEST_LINE] if line else source
        return f"{describe_foreign_characters(foreign)}\nLigne lue : {remove_control_characters(shown)}"
    where = f"Ligne {line} : " if line else ""
    sentence = explain_syntax(text, source)
    quoted = f"\nLigne lue : {source}" if source else ""
    return f"{where}{sentence if where else sentence[:1].upper() + sentence[1:]}.{quoted}"


def unreadable_line(reason: str, line: int) -> str:
    """Return the sentence of a line for which Python is not asked."""
    return f"Ligne {line} : {reason}."


def null_byte() -> str:
    return "un octet nul se trouve dans le fichier : ce n’est pas un fichier de texte (enregistrez-le en UTF-8)"


def piled_marks() -> str:
    return f"une lettre porte plus de {MAX_MARKS} accents l’un sur l’autre : effacez-la, et retapez-la au clavier"


def source_too_big(length: int, policy: Policy) -> str:
    return (
        f"Votre fichier fait {format_byte_size(length)}, et la limite est de {format_byte_size(policy.source_bytes)}. "
        "N’y laissez que vos fonctions, sans données recopiées."
    )


def runtime_error(
    exception: str,
    text: str,
    line: int | None,
    frames: tuple[Frame, ...],
    values: str = "",
    file_lines: Sequence[str] = (),
) -> str:
    """Return the sentence of an exception with its line; see `describe_exception`."""
    return prefix_with_line(line, frames, describe_exception(exception, text, frames, values, file_lines))


def import_error(exception: str, module: str, text: str, line: int | None, frames: tuple[Frame, ...]) -> str:
    if exception != "ModuleNotFoundError" and module == library.NAME and (name := _MISSING_NAME.match(text)):
        return prefix_with_line(line, frames, f"{library.NAME} ne donne pas « {name[1]} » ici. {_NOT_GIVEN}")
    if explained := explain_import(exception, module, text):
        return prefix_with_line(line, frames, f"{explained} [{exception}]")
    if exception != "ModuleNotFoundError":
        what = f"Une partie du module « {module} »" if module else "Une partie d’un module"
        return prefix_with_line(line, frames, f"{what} ne s’importe pas ici. [{exception}]")
    return prefix_with_line(line, frames, f"le module « {module} » n’est pas disponible ici. {_module_advice(module)}")


_MISSING_NAME = re.compile("cannot import name '(.+?)'")
_NOT_GIVEN = (
    "Ce module rend vos fonctions des exercices réussis et, pour les autres, celles du cours, sauf ce qu’un contrôle "
    "en cours ou cet exercice demande d’écrire : écrivez la fonction dans ce fichier, ou vérifiez son nom."
)


def _module_advice(module: str) -> str:
    root = module.partition(".")[0]
    if root in drawing_stand_ins.ROOTS:
        return "Rien ne se trace pendant l’évaluation."
    for names in (("numpy", "scipy"), sys.stdlib_module_names):
        near = difflib.get_close_matches(root, names, 1, 0.75)
        if near and near[0] != root:
            return f"Vouliez-vous écrire « {near[0]} » ?"
    return "Sont disponibles numpy, scipy et la bibliothèque standard de Python."


def missing_function(name: str, present: Iterable[str], exit_line: int | None = None, *, written: bool = True) -> str:
    """`exit_line`: where the file stopped by itself; `written`: whether it holds anything."""
    functions = sorted(map(remove_control_characters, present))
    by_lower_case = {function.casefold(): function for function in functions}
    near = [by_lower_case[close] for close in difflib.get_close_matches(name.casefold(), by_lower_case, 1, 0.6)]
    sentence = f"La fonction « {name} » est attendue et n’est pas dans votre fichier. "
    if exit_line is not None:
        return f"{sentence}La lecture du fichier s’est arrêtée ligne {exit_line}, à « exit » : retirez cette ligne."
    if near:
        return sentence + f"Il contient « {near[0]} » : est-ce elle, sous un autre nom ?"
    if functions:
        return sentence + f"Il contient : {', '.join(functions[:10])}."
    return sentence + ("Il ne contient aucune fonction." if written else "Il est vide : a-t-il été enregistré ?")


def timeout(what: str, policy: Policy, line: int | None, frames: tuple[Frame, ...]) -> str:
    if what == "cpu":
        limit = f"votre programme a calculé pendant plus de {format_seconds(policy.cpu_seconds)}, la limite"
    else:
        limit = f"votre programme n’a pas répondu en {format_seconds(policy.wall_seconds)}, la limite"
    return prefix_with_line(
        line, frames, f"{limit}. Une boucle ne se termine-t-elle jamais, ou fait-elle un travail inutile ?"
    )


def memory_limit(policy: Policy, line: int | None, frames: tuple[Frame, ...]) -> str:
    sentence = f"votre programme demande plus de mémoire que la limite de {format_byte_size(policy.memory_bytes)}. "
    advice = "Un tableau a-t-il des dimensions démesurées, une liste grandit-elle sans fin ?"
    return prefix_with_line(line, frames, sentence + advice)


def forbidden(text: str, line: int | None, frames: tuple[Frame, ...]) -> str:
    """Return the sentence of an operation that a wall refused; `text` is the system's, of which a path is told."""
    path = re.search(r": '([^']{1,80})'", text)
    what = f" sur « {path[1]} »" if path else ""
    advice = "Fichiers, réseau, processus et fils d’exécution sont hors d’atteinte : tout arrive par les arguments."
    return prefix_with_line(line, frames, f"opération interdite{what}. {advice}")


def exited(code: int) -> str:
    return (
        f"Votre programme s’est arrêté de lui-même (code {code}) avant de répondre : "
        "n’appelez ni « os._exit » ni « exit », et renvoyez le résultat par « return »."
    )


def killed_by_signal(number: int) -> str:
    name = signal.Signals(number).name if number in set(signal.Signals) else f"signal {number}"
    why = _SIGNALS.get(signal.Signals(number)) if number in set(signal.Signals) else None
    return f"Votre programme a été arrêté par le système ({name}){' : ' + why if why else ''}."


def forged() -> str:
    return (
        "Votre programme a écrit lui-même sur le canal des résultats, qui n’est pas à lui : "
        "renvoyez le résultat par « return », et affichez avec « print »."
    )


def _count_values_in_french(count: int) -> str:
    return f"{count:,} valeurs".replace(",", "\u202f")


def answer_too_big(what: str, function: str, policy: Policy) -> str:
    limit = _count_values_in_french(policy.items) if what == "items" else format_byte_size(policy.frame_bytes)
    return f"Le résultat de « {function} » est trop gros : la limite est de {limit}."


def answers_too_big(what: str, policy: Policy) -> str:
    limit = _count_values_in_french(policy.session_items) if what == "items" else format_byte_size(policy.session_bytes)
    return (
        f"Ce que vos fonctions ont renvoyé dépasse, en tout, la limite de {limit} : le programme est arrêté là. "
        "Ne renvoyez que ce qui est demandé : ni liste ni tableau qui grandit d’un appel à l’autre."
    )


def judging_too_long(policy: Policy) -> str:
    return (
        f"Lire et comparer ce que vos fonctions renvoient a pris plus de {format_seconds(policy.judging_seconds)} de "
        "calcul, la limite : ce sont des valeurs bien plus grandes que celles qui sont demandées."
    )


_NOT_A_VALUE = {
    "depth": "a plus de {depth} niveaux imbriqués (se contient-il lui-même ?).",
    "int": "contient un entier démesurément grand.",
    "key": "contient un dictionnaire dont une clé est de type « {culprit} » : seules des chaînes sont acceptées.",
    "dtype": "contient un tableau d’éléments « {culprit} » : des nombres ou des booléens sont attendus.",
    "object": "contient un tableau d’objets qui ne sont pas des nombres : ses lignes ont-elles la même longueur ?",
}


def not_a_value(reason: str, culprit: str, where: str, function: str, policy: Policy) -> str:
    """Why what a function returned cannot be sent: `reason` and the place `where` it was found come from the codec.

    The place begins with [0] in the value itself, and with [1] in the arguments after the call.
    """
    subject = f"Le résultat de « {function} »" if where.startswith("[0]") else f"Un argument modifié par « {function} »"
    inside = where[3:] if where.startswith("[0]") else ""
    if reason in _NOT_A_VALUE:
        return f"{subject} {_NOT_A_VALUE[reason].format(depth=policy.depth, culprit=culprit)}"
    predicate = (
        f"contient, en {inside}, une valeur" if inside else "est" if where.startswith("[0]") else "contient une valeur"
    )
    advice = _advice_for_unsendable_type(culprit)
    return f"{subject} {predicate} de type « {culprit} » : ni nombre, ni tableau, ni liste. {advice}"


_ITERABLES = ("generator", "map", "filter", "zip", "enumerate", "reversed", "dict_keys", "dict_values", "dict_items")


def _advice_for_unsendable_type(culprit: str) -> str:
    if culprit in _ITERABLES:
        return "Entourez-la de « list(…) » ou de « np.array(…) »."
    if culprit in ("set", "frozenset"):
        return "Un ensemble n’a pas d’ordre : renvoyez « sorted(…) »."
    if culprit in ("function", "method", "builtin_function_or_method"):
        return "Les parenthèses de l’appel ont-elles été oubliées ?"
    return "Renvoyez un tableau numpy, une liste ou un nombre."
