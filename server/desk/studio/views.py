"""What the pages of a teacher's exercises show."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from markupsafe import Markup

from graders.core.contract.verdict import Verdict
from graders.core.declared.declaration import DEFAULT_DRAWS
from graders.core.declared.trial_report import TrialReport, TriedCase, TriedChange
from server.base.app_services import app_service
from server.classes.repository import load_taught_classes
from server.course import Course
from server.course.functions import FunctionSpec
from server.desk.studio.forms import REASON_FIELD
from server.identity.models import Account
from server.studio import repository, service
from server.studio.completion import DRAWN_POINTS
from server.studio.drafts import CaseDraft, CheckDraft, ExerciseDraft, MistakeDraft, program_digest
from server.studio.importing import ImportedExercise
from server.studio.models import AuthoredExercise
from server.studio.service import StudioService
from server.text.markup import Names, Source, Text
from server.web.form_version import version_of
from server.web.verdicts import verdict_view
from server.web.views import Reader

PATH = "/mes-exercices"
EXAMPLE_ROWS, OFFERED_MISTAKES = 3, 8
#: Exercises of a page of the list, and those below which nobody searches.
ROWS, FEW_ROWS = 30, 8
#: Characters and formulas of a statement that is drawn: one thread draws the formulas of all.
MAX_STATEMENT, MAX_FORMULAS = 12_000, 60
TOO_LONG = f"Cet énoncé dépasse {MAX_STATEMENT} caractères, ou {MAX_FORMULAS} formules : il n’est pas montré."
_PLACE = re.compile(r"(verifications|erreurs)\[(\d+)\](?:\.(\w+)(?:\[(\d+)\])?)?")
#: A decimal number among a value's digits, in which another right method may change the last ones.
_DECIMAL = re.compile(r"\d\.\d|\de-\d")
_DECIMAL_COMMA = re.compile(r"(?<![\w.,])-?\d+,\d+(?![\w,])")
#: Exceptions of a solution that no statement asks for.
_NEVER_ASKED = frozenset({"NameError", "UnboundLocalError", "ImportError", "ModuleNotFoundError", "SystemError"})
_PART_WORDS = {"fonctions": "les fonctions", "solution": "la solution", "verifications": "les vérifications"}
_FIELD_WORDS = {
    "cas": "le cas", "attendus": "le résultat attendu du cas", "tirages": "les tirages", "appel": "l’appel tiré",
    "points": "les points", "tolerance": "la tolérance", "combien": "le nombre de tirages", "ordre": "l’ordre",
    "regarder": "ce qui est regardé", "programme": "le programme", "titre": "le titre",
}  # fmt: skip


@dataclass(frozen=True)
class StudioReader:
    """The reader of a studio page with the service that knows what is being tried."""

    reader: Reader
    studio: StudioService


def exercise_path(exercise: AuthoredExercise) -> str:
    return f"{PATH}/{exercise.id}"


def public_href(exercise: AuthoredExercise) -> str:
    """Return the address at which students do it; empty before it is published."""
    return f"/{exercise.module}/exercices/{exercise.slug}" if exercise.name else ""


def build_list_page(
    reader: Reader, account: Account, *, query: str = "", page: int = 1, code: str = "", problem: str = ""
) -> dict[str, Any]:
    """Build a page of one's exercises that hold the words of a query; `problem` says why none has the typed `code`."""
    own = repository.list_exercises(reader.db, account.id)
    found = service.search_exercises(own, query)
    exercises, more = _page_of(found, page)
    rows = [
        {
            "href": exercise_path(exercise),
            "title": exercise.draft.get("title") or "Sans titre",
            "module": _module_label(reader.course, exercise.module),
            "saved_at": exercise.saved_at,
            "public": public_href(exercise),
            "state": _state(exercise),
        }
        for exercise in exercises
    ]
    taught = load_taught_classes(reader.db, account.id) if not own else ()
    chosen = own[0].module if own else next((each.module for each in taught), "")
    return {
        "rows": rows, "modules": _modules(reader.course), "chosen": chosen, "code": code, "problem": problem,
        "query": query, "count": len(own), "found": len(found), "number": page, "more": more,
        "searches": len(own) > FEW_ROWS, "address": _page_address(PATH, query),
    }  # fmt: skip


def _page_of(exercises: Sequence[AuthoredExercise], page: int) -> tuple[Sequence[AuthoredExercise], bool]:
    """Return the rows of a page, and whether more come after it."""
    return exercises[(page - 1) * ROWS : page * ROWS], len(exercises) > page * ROWS


def _page_address(path: str, query: str) -> str:
    """Return the address of a list to which the number of a page is added."""
    return f"{path}?{urlencode({'q': query})}&page=" if query else f"{path}?page="


def build_import_page(
    reader: Reader, rows: Sequence[tuple[ImportedExercise, str]] = (), *, problem: str = ""
) -> dict[str, Any]:
    """Build the form of an import; `rows` are what came over, each with the address of its draft."""
    return {"modules": _modules(reader.course), "rows": rows, "problem": problem}


def build_bank_page(reader: Reader, found: Sequence[AuthoredExercise], *, query: str, page: int) -> dict[str, Any]:
    exercises, more = _page_of(found, page)
    rows = [
        {
            "id": exercise.id,
            "draft": service.read_draft(exercise),
            "module": _module_label(reader.course, exercise.module),
            "public": public_href(exercise),
        }
        for exercise in exercises
    ]
    address = _page_address(f"{PATH}/banque", query)
    return {"rows": rows, "query": query, "number": page, "more": more, "address": address}


def _modules(course: Course) -> list[tuple[str, str, str]]:
    """Return name, label and title of the modules for which one may write exercises."""
    return [(module.slug, module.label, module.title) for module in course.latest]


def _module_label(course: Course, slug: str) -> str:
    module = course.modules.get(slug)
    return slug if module is None else module.label


def _state(exercise: AuthoredExercise) -> str:
    if not exercise.number:
        return "brouillon"
    trial = exercise.trial or {}
    is_current = trial.get("published") is True and trial.get("digest") == exercise.digest
    return f"publié, version {exercise.number}" + ("" if is_current else " ; modifié depuis")


def build_edit_page(
    context: StudioReader, exercise: AuthoredExercise, draft: ExerciseDraft, *, problem: str = ""
) -> dict[str, Any]:
    """Build the form with `draft`, the preview of its statement and the last trial."""
    return {
        "path": exercise_path(exercise),
        "module": _module_label(context.reader.course, exercise.module),
        "slug": exercise.module,
        "draft": draft,
        "checks": [_with_rows(check, EXAMPLE_ROWS) for check in draft.checks or (CheckDraft(),)],
        "extras": _extras(draft),
        "extra_check": _with_rows(CheckDraft(), EXAMPLE_ROWS),
        "mistakes": [*draft.mistakes, MistakeDraft()],
        "version": version_of(service.read_draft(exercise).texts),
        "preview": render_statement(context.reader.course, exercise.module, draft.statement),
        "report": build_report(context, exercise),
        "problem": problem,
        "may_delete": not exercise.number,
        "share_code": exercise.share_code or "",
        "in_bank": exercise.in_bank,
        "tried": "completed" in (exercise.trial or {}),
        "for_classes": exercise.for_classes,
    }


def build_tryout_page(context: StudioReader, exercise: AuthoredExercise) -> dict[str, Any]:
    """Build the page of a draft as a student sees it, with the verdict of what its author sent there."""
    _, content = service.archived_content(exercise)
    declaration, tryout = content["declaration"], exercise.tryout or {}
    signatures = content["signatures"]
    functions = [FunctionSpec(name, signatures.get(name, name), "", "") for name in declaration["fonctions"]]
    verdict = tryout.get("verdict")
    return {
        "path": exercise_path(exercise),
        "title": content["title"],
        "summary": content["summary"],
        "module": _module_label(context.reader.course, exercise.module),
        "functions": functions,
        "statement": render_statement(context.reader.course, exercise.module, content["statement"]),
        "hints": [hint for hint in content["hints"] if hint.strip()],
        "code": tryout.get("code", content["starter"]),
        "waits": context.studio.is_trying(context.reader.db, exercise, service.TRYOUT_JOB),
        "failed": tryout.get("failed", ""),
        "verdict": verdict_view(Verdict.from_json(verdict), "", functions=functions) if verdict else None,
    }


def _with_rows(check: CheckDraft, rows: int) -> dict[str, Any]:
    """Return a check with an empty row after its cases, and at least so many rows."""
    empty = [CaseDraft()] * max(1, rows - len(check.cases))
    return {"check": check, "rows": [*check.cases, *empty], "settings": list(_settings(check))}


def _settings(check: CheckDraft) -> Iterator[str]:
    """Yield what an author has set of a check, in short: a fold that is closed must not hide it."""
    texts = (
        (check.title, "titre"), (check.points, "points : {}"), (check.tolerance, "écart permis : {}"),
        (check.draws, "tirages"), (check.count, "{} tirages"), (check.conditions, "conditions"),
        (check.hint, "indice"), (check.lines, "saisie au clavier"), (check.files, "fichiers"),
    )  # fmt: skip
    yield from (words.format(text.strip()) for text, words in texts if text.strip())
    flags = (
        (check.absolute, "écart absolu"), (check.strict, "types stricts"), (check.ignores_spaces, "espaces libres"),
        (check.order != "oui", "ordre libre"), (check.watched == "affichage", "affichage"),
        (check.watched == "fichiers", "fichiers écrits"),
    )  # fmt: skip
    yield from (words for is_set, words in flags if is_set)


def _extras(draft: ExerciseDraft) -> list[str]:
    """Return what an author has set beyond the five-minute form."""
    texts = (
        (draft.starter, "fichier de départ"), (draft.functions, "fonctions"), ("".join(draft.hints), "indices"),
        (draft.forbidden, "interdit : {}"), (draft.required, "demandé : {}"), (draft.summary, "résumé"),
        (draft.level, "niveau : {}"), (draft.themes, "thèmes : {}"),
    )  # fmt: skip
    return [words.format(text.strip()[:60]) for text, words in texts if text.strip()]


def build_report(context: StudioReader, exercise: AuthoredExercise) -> dict[str, Any]:
    """Build the panel of the last trial: what holds, what is to be mended, what is proposed."""
    trial, draft = exercise.trial or {}, service.read_draft(exercise)
    is_current = trial.get("digest") == exercise.digest
    view: dict[str, Any] = {
        "path": exercise_path(exercise),
        "version": version_of(draft.texts),
        "trying": context.studio.is_trying(context.reader.db, exercise),
        "failed": trial.get("failed", ""),
        "stale": bool(trial) and not is_current,
        "faults": trial.get("faults", ()),
        "left": trial.get("left") if is_current else None,
        "number": exercise.number,
        "public": public_href(exercise),
        "tried": "completed" in trial,
        "for_classes": exercise.for_classes,
        "published_now": trial.get("published", False) and is_current and not trial.get("faults") and exercise.number,
        "report": None,
    }
    if "report" in trial:
        view |= _read_report(TrialReport.from_data(trial["report"]), trial["completed"], draft)
    return view


def _read_report(report: TrialReport, completed: Mapping[str, Any], draft: ExerciseDraft) -> dict[str, Any]:
    checks = completed["declaration"]["verifications"]
    titles = {each["id"]: each["titre"] or "sans titre" for each in completed["declaration"]["erreurs"]}
    changes = report.changes
    holds = not (report.problem or report.solution) and all(case.agrees for case in report.cases)
    return {
        "report": report,
        "place": describe_place(report.place),
        "answers": [_answer(checks[case.check], case) for case in report.cases],
        "right": sum(case.agrees for case in report.cases),
        "mistakes": [
            (titles.get(tried.id, tried.id), tried, titles.get(tried.instead, "")) for tried in report.mistakes
        ],
        "untried": len(titles) if not holds else 0,
        "tolerances": _tolerances(report, draft),
        "missing_cases": any(tried.case for tried in report.mistakes),
        "offered": _offered_mistakes(changes, draft),
        "alive": _survivors(report, draft),
        "alive_count": len(report.survivors),
        "unseen": sum(change.unseen for change in changes),
        "refused": sum(bool(change.refusal) for change in changes),
        "draws": {key: completed.get(key, "") for key in ("draws", "call", "conditions", "drawn")}
        | {"count": DEFAULT_DRAWS, "points": DRAWN_POINTS},
    }


def _tolerances(report: TrialReport, draft: ExerciseDraft) -> list[tuple[int, str]]:
    """Return the checks whose answers have decimal numbers, with the tolerance that their author has chosen."""
    decimal = sorted({case.check for case in report.cases if not case.fault and _is_decimal(case.given)})
    return [(at, draft.checks[at].tolerance) for at in decimal if at < len(draft.checks)]


def _is_decimal(text: str) -> bool:
    return not text.startswith(("'", '"')) and _DECIMAL.search(text) is not None


def _answer(check: Mapping[str, Any], case: TriedCase) -> dict[str, Any]:
    expected = check.get("attendus", ())
    wanted = expected[case.case] if case.case < len(expected) else ""
    call = check["cas"][case.case]
    comma = "" if case.agrees else _decimal_comma(wanted) or (_decimal_comma(call) if case.fault else "")
    may_expect = bool(case.raised) and case.raised not in _NEVER_ASKED
    return {"call": call, "expected": wanted, "got": case, "comma": comma, "may_expect": may_expect}


def _decimal_comma(text: str) -> str:
    """Return a number that a text writes as in French, « 1,1 », which Python reads as two values; empty without one."""
    found = _DECIMAL_COMMA.search(text)
    return found[0] if found else ""


def _offered_mistakes(changes: Sequence[TriedChange], draft: ExerciseDraft) -> list[tuple[str, TriedChange]]:
    """Return refused changes that are no known mistakes yet, by the digests of their programs.

    Wrong values come first, which teach more than exceptions, and changes of a line before whole functions; of changes
    that are refused in the same words, one.
    """
    known = {mistake.program.strip() for mistake in draft.mistakes}
    refused = [change for change in changes if change.refusal and change.program.strip() not in known]
    refused.sort(key=lambda change: (not change.refusal.startswith(("Pour ", "Dans ")), bool(change.words)))
    distinct = {change.refusal: change for change in reversed(refused)}
    offered = [change for change in refused if distinct[change.refusal] is change][:OFFERED_MISTAKES]
    return [(program_digest(change.program), change) for change in offered]


def _survivors(report: TrialReport, draft: ExerciseDraft) -> list[tuple[list[TriedChange], str, str]]:
    """Return the changes that survive, by the cases that would refuse them, with the field and the text of a reason."""
    by_case: dict[str, list[TriedChange]] = {}
    for change in report.survivors:
        by_case.setdefault(change.case or change.program, []).append(change)
    groups = [(group, [program_digest(change.program) for change in group]) for group in by_case.values()]
    return [
        (group, REASON_FIELD + "-".join(digests), next(filter(None, map(draft.reasons.get, digests)), ""))
        for group, digests in groups
    ]


def describe_place(place: str) -> str:
    """Return where something is wrong in the words of the form: « vérification 1, le cas 2 »."""
    found = _PLACE.match(place)
    if found is None:
        return _PART_WORDS.get(place, place)
    what = "vérification" if found[1] == "verifications" else "erreur"
    field = f", {_FIELD_WORDS.get(found[3], found[3])}" if found[3] else ""
    return f"{what} {int(found[2]) + 1}{field}" + (f" {int(found[4]) + 1}" if found[4] else "")


def render_statement(course: Course, module: str, text: str) -> Markup:
    """Return a statement as HTML: the course's Markdown, in which nothing runs. A note for one that is too long."""
    if len(text) > MAX_STATEMENT or text.count("$") > 2 * MAX_FORMULAS:
        return Markup("<p>{}</p>").format(TOO_LONG)
    served = course.modules.get(module)
    names = served.names if served is not None else Names
    return Markup(Text(Source(text, Path("énoncé"), names=names)).html)


studio_service = app_service(StudioService)
