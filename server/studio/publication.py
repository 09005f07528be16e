"""When a draft may be published, and what its version holds."""

from __future__ import annotations

import hashlib
import json
import re
import secrets
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from graders.core.declared.body_changes import WHOLE_BODY
from graders.core.declared.trial import MAX_ALIVE, SEEDS
from graders.core.declared.trial_report import TrialReport, TriedMistake
from graders.typography import unaccented
from server.studio.completion import CompletedExercise
from server.studio.drafts import ExerciseDraft, program_digest

#: Letters and digits that are not taken for one another, of the end of a published exercise's name.
ALPHABET, SUFFIX_LENGTH = "23456789abcdefghjkmnpqrstvwxyz", 6
#: Changes of whole functions that a fault names.
SHOWN_CHANGES = 4
UNREADABLE = "Corrigez d’abord ce qui ne se lit pas : c’est dit plus bas, avec sa place."
NOT_ANSWERED = "La solution ne répond pas encore comme les exemples le disent : voyez ce qui est marqué ✗."
#: The name of a published exercise in addresses: no exercise of a course is looked up in the database.
AUTHORED_SLUG = re.compile(rf"[a-z][a-z0-9_]{{0,40}}_[{ALPHABET}]{{{SUFFIX_LENGTH}}}")


def draw_slug(title: str) -> str:
    """Return a name for addresses that nobody guesses, from a title."""
    words = re.sub(r"[^a-z0-9]+", "_", unaccented(title)).strip("_")[:40].strip("_")
    words = words if words[:1].isalpha() else f"ex_{words}".strip("_")
    return f"{words}_{draw_share_code(SUFFIX_LENGTH)}"


def draw_share_code(length: int) -> str:
    return "".join(secrets.choice(ALPHABET) for _ in range(length))


def version_digest(declaration: Mapping[str, Any]) -> str:
    """Return the version of a declaration: a digest of all that can change a verdict."""
    text = json.dumps(declaration, ensure_ascii=False, sort_keys=True)
    return hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()[:16]


def find_publication_faults(
    draft: ExerciseDraft, completed: CompletedExercise, report: TrialReport, *, seeds: int = SEEDS
) -> Iterator[str]:
    """Yield why a draft may not be published: what is wrong, where, and what to do.

    `seeds` is the number of seeds on which the solution must have been graded.
    """
    if not draft.title.strip():
        yield "Donnez un titre à l’exercice."
    if not draft.statement.strip():
        yield "Écrivez l’énoncé."
    if report.problem or report.solution or not all(case.agrees for case in report.cases):
        yield UNREADABLE if report.problem else NOT_ANSWERED
        return
    if report.starter:
        yield f"{report.starter} Videz le corps des fonctions du fichier de départ."
    if report.seeds < seeds and report.is_whole:
        yield f"La solution n’a été notée que sur {report.seeds} tirages ; il en faut {seeds}."
    titles = {each["id"]: each for each in completed.declaration["erreurs"]}
    for tried in report.mistakes:
        title = titles[tried.id]["titre"] or "sans titre"
        if not titles[tried.id]["programme"].strip():
            yield f"Écrivez le programme qui commet l’erreur « {title} », ou retirez-la."
        elif not tried.refused:
            yield f"L’erreur « {title} » n’est pas refusée : {_advise_on_case(tried, 'où elle répond mal')}"
        elif not tried.named:
            yield f"L’erreur « {title} » n’est pas reconnue : {_advise_on_case(tried, 'où elle diffère des autres')}"
        if not (titles[tried.id]["titre"] and titles[tried.id]["explication"]):
            yield f"Dites en mots l’erreur « {title} » : un titre et une explication."
    yield from _find_faults_of_changes(draft, report)
    if report.is_busy:
        yield "Le serveur est très chargé et l’essai n’a pas pu tout essayer : réessayez dans quelques minutes."
    elif not report.is_whole:
        yield "L’essai a pris trop de temps et n’a pas tout essayé : donnez des entrées plus petites."


def _find_faults_of_changes(draft: ExerciseDraft, report: TrialReport) -> Iterator[str]:
    """Yield what the changed solutions that have all points show: each of a whole function, too many of the others."""
    alive = [
        change
        for change in report.proven_survivors
        if not draft.reasons.get(program_digest(change.program), "").strip()
    ]
    whole = [change.words for change in alive if change.operator in WHOLE_BODY]
    small = [change for change in report.changes if change.operator not in WHOLE_BODY]
    lines = len(alive) - len(whole)
    shown = whole[:SHOWN_CHANGES] + [f"{len(whole) - SHOWN_CHANGES} autres"] * (len(whole) > SHOWN_CHANGES)
    if lines > MAX_ALIVE * len(small):
        shown.append(f"{lines} {'modification' if lines == 1 else 'modifications'} d’une ligne")
    if shown:
        yield (
            f"Des programmes faux auraient 20/20 : {' ; '.join(shown)}. Ajoutez les cas proposés plus bas, ou dites "
            "pourquoi la réponse est juste aussi."
        )
    if small and 2 * sum(bool(change.refusal) for change in small) < len(small):
        yield (
            "Les exemples ne montrent pas ce que fait la solution : plus de la moitié de ses modifications passent. "
            "Ajoutez des exemples plus variés."
        )


def _advise_on_case(tried: TriedMistake, where: str) -> str:
    """Return what an author is to do about a mistake that no case shows."""
    if tried.case:
        return f"ajoutez le cas `{tried.case}`, {where} (cochez-le plus bas)."
    return f"ajoutez un cas {where}, ou retirez-la."


def version_content(completed: CompletedExercise) -> dict[str, Any]:
    """Return what a version stores."""
    return {
        "title": completed.title,
        "summary": completed.summary,
        "statement": completed.statement,
        "starter": completed.starter,
        "signatures": completed.signatures,
        "hints": list(completed.hints),
        "declaration": completed.declaration,
    }


def add_reason(draft: ExerciseDraft, program: str, reason: str) -> ExerciseDraft:
    """Return the draft with the reason why a change of the solution need not be refused."""
    return replace(draft, reasons={**draft.reasons, program_digest(program): reason})
