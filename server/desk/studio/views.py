"""What the pages of a teacher's exercises show."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from markupsafe import Markup

from graders.core.contract.verdict import Verdict
from graders.core.declared.trial_report import TrialReport
from server.base.app_services import app_service
from server.classes.repository import load_taught_classes
from server.course import Course
from server.course.functions import FunctionSpec
from server.desk.studio.report_views import build_report_view
from server.identity.models import Account
from server.studio import repository, service
from server.studio.drafts import CaseDraft, CheckDraft, ExerciseDraft, MistakeDraft
from server.studio.importing import ImportedExercise
from server.studio.models import AuthoredExercise
from server.studio.service import StudioService
from server.text.markup import MarkdownSource, MarkdownText, ModuleNames
from server.web.form_version import form_version_tag
from server.web.verdicts import build_verdict_view
from server.web.views import Reader

PATH = "/mes-exercices"
EXAMPLE_ROWS = 3
#: Exercises of a page of the list, and those below which nobody searches.
ROWS, FEW_ROWS = 30, 8
#: Characters and formulas of a statement that is drawn: one thread draws the formulas of all.
MAX_STATEMENT, MAX_FORMULAS = 12_000, 60
TOO_LONG = f"Cet énoncé dépasse {MAX_STATEMENT} caractères, ou {MAX_FORMULAS} formules : il n’est pas montré."


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
    exercises, more = _slice_page(found, page)
    rows = [
        {
            "href": exercise_path(exercise),
            "title": exercise.draft.get("title") or "Sans titre",
            "module": _module_label(reader.course, exercise.module),
            "saved_at": exercise.saved_at,
            "public": public_href(exercise),
            "state": _state_in_words(exercise),
        }
        for exercise in exercises
    ]
    taught = load_taught_classes(reader.db, account.id) if not own else ()
    chosen = own[0].module if own else next((each.module for each in taught), "")
    return {
        "rows": rows, "modules": _module_options(reader.course), "chosen": chosen, "code": code, "problem": problem,
        "query": query, "count": len(own), "found": len(found), "number": page, "more": more,
        "searches": len(own) > FEW_ROWS, "address": _page_address(PATH, query),
    }  # fmt: skip


def _slice_page(exercises: Sequence[AuthoredExercise], page: int) -> tuple[Sequence[AuthoredExercise], bool]:
    """Return the rows of a page, and whether more come after it."""
    return exercises[(page - 1) * ROWS : page * ROWS], len(exercises) > page * ROWS


def _page_address(path: str, query: str) -> str:
    """Return the address of a list to which the number of a page is added."""
    return f"{path}?{urlencode({'q': query})}&page=" if query else f"{path}?page="


def build_import_page(
    reader: Reader, rows: Sequence[tuple[ImportedExercise, str]] = (), *, problem: str = ""
) -> dict[str, Any]:
    """Build the form of an import; `rows` are what came over, each with the address of its draft."""
    return {"modules": _module_options(reader.course), "rows": rows, "problem": problem}


def build_bank_page(reader: Reader, found: Sequence[AuthoredExercise], *, query: str, page: int) -> dict[str, Any]:
    exercises, more = _slice_page(found, page)
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


def _module_options(course: Course) -> list[tuple[str, str, str]]:
    """Return name, label and title of the modules for which one may write exercises."""
    return [(module.slug, module.label, module.title) for module in course.latest]


def _module_label(course: Course, slug: str) -> str:
    module = course.modules.get(slug)
    return slug if module is None else module.label


def _state_in_words(exercise: AuthoredExercise) -> str:
    if not exercise.number:
        return "brouillon"
    state = f"publié, version {exercise.number}" + (
        "" if service.is_current_draft_published(exercise) else " ; modifié depuis"
    )
    return state + (" ; proposé à vos classes" if exercise.for_classes else "")


def _proposed_classes(reader: Reader, exercise: AuthoredExercise) -> list[str]:
    """Return the names of the classes that find an exercise in their module."""
    if not (exercise.for_classes and exercise.author_id):
        return []
    return [it.name for it in load_taught_classes(reader.db, exercise.author_id) if it.module == exercise.module]


def build_edit_page(
    context: StudioReader, exercise: AuthoredExercise, draft: ExerciseDraft, *, problem: str = ""
) -> dict[str, Any]:
    """Build the form with `draft`, the preview of its statement and the last trial."""
    return {
        "path": exercise_path(exercise),
        "module": _module_label(context.reader.course, exercise.module),
        "slug": exercise.module,
        "draft": draft,
        "checks": [_check_form_with_rows(check, EXAMPLE_ROWS) for check in draft.checks or (CheckDraft(),)],
        "extras": _extra_descriptions(draft),
        "extra_check": _check_form_with_rows(CheckDraft(), EXAMPLE_ROWS),
        "mistakes": [*draft.mistakes, MistakeDraft()],
        "version": form_version_tag(service.read_draft(exercise).texts_by_label),
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
    _, content = service.content_to_archive(exercise)
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
        "waits": context.studio.is_trial_queued(context.reader.db, exercise, service.TRYOUT_JOB),
        "failed": tryout.get("failed", ""),
        "verdict": build_verdict_view(Verdict.from_json(verdict), "", functions=functions) if verdict else None,
    }


def _check_form_with_rows(check: CheckDraft, rows: int) -> dict[str, Any]:
    """Return a check with an empty row after its cases, and at least so many rows."""
    empty = [CaseDraft()] * max(1, rows - len(check.cases))
    return {"check": check, "rows": [*check.cases, *empty], "settings": list(_setting_descriptions(check))}


def _setting_descriptions(check: CheckDraft) -> Iterator[str]:
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


def _extra_descriptions(draft: ExerciseDraft) -> list[str]:
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
        "version": form_version_tag(draft.texts_by_label),
        "trying": context.studio.is_trial_queued(context.reader.db, exercise),
        "failed": trial.get("failed", ""),
        "stale": bool(trial) and not is_current,
        "faults": trial.get("faults", ()),
        "left": trial.get("left") if is_current else None,
        "number": exercise.number,
        "public": public_href(exercise),
        "tried": "completed" in trial,
        "for_classes": exercise.for_classes,
        "classes": _proposed_classes(context.reader, exercise),
        "published_now": service.is_current_draft_published(exercise),
        "report": None,
    }
    if "report" in trial:
        view |= build_report_view(TrialReport.from_data(trial["report"]), trial["completed"], draft)
    return view


def render_statement(course: Course, module: str, text: str) -> Markup:
    """Return a statement as HTML: the course's Markdown, in which nothing runs. A note for one that is too long."""
    if len(text) > MAX_STATEMENT or text.count("$") > 2 * MAX_FORMULAS:
        return Markup("<p>{}</p>").format(TOO_LONG)
    served = course.modules.get(module)
    names = served.names if served is not None else ModuleNames
    return Markup(MarkdownText(MarkdownSource(text, Path("énoncé"), names=names)).html)


studio_service = app_service(StudioService)
