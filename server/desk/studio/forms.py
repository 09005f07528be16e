"""The form of an exercise: from what is typed to a draft. It refuses nothing: what is wrong is told beside it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from starlette.datastructures import FormData, UploadFile

from server.studio.drafts import (
    CHECK_CHOICES,
    HINTS,
    MAX_CASES,
    MAX_CHECKS,
    MAX_MISTAKES,
    CaseDraft,
    CheckDraft,
    ExerciseDraft,
    MistakeDraft,
)

YES = "oui"
REASON_FIELD = "raison-"
MAX_REASONS = 60
#: Ticked proposals of the trial: cases, and changes of the solution by their digests.
PICKED_CASES, PICKED_CHANGES = "cas", "erreur"
#: Rows beyond the bounds are read, so that they are told and not lost.
ROOM = 2
_CHECK_TEXTS = {
    "title": "titre", "points": "points", "hint": "indice", "draws": "tirages", "call": "appel", "count": "combien",
    "conditions": "conditions", "tolerance": "tolerance", "order": "ordre", "watched": "regarder", "lines": "entrees",
    "files": "fichiers",
}  # fmt: skip
_CHECK_FLAGS = {"absolute": "absolue", "strict": "stricts", "ignores_spaces": "espaces"}
_EXERCISE_TEXTS = {
    "title": "titre", "summary": "resume", "level": "niveau", "themes": "themes", "statement": "enonce",
    "functions": "fonctions", "solution": "solution", "starter": "depart", "forbidden": "interdits",
    "required": "demandes",
}  # fmt: skip
_MISTAKE_TEXTS = {"title": "titre", "explanation": "explication", "question": "question", "program": "programme"}
_REASON = re.compile(rf"{REASON_FIELD}([0-9a-f]{{12}}(?:-[0-9a-f]{{12}})*)")


def read_exercise_draft(fields: FormData, before: ExerciseDraft) -> ExerciseDraft:
    """Return what is typed; reasons that the form does not show stay as they were `before`."""
    texts = {name: _text_field(fields, field) for name, field in _EXERCISE_TEXTS.items()}
    reasons = dict(before.reasons)
    for name, value in fields.multi_items():
        shown = _REASON.fullmatch(name)
        if shown and isinstance(value, str):
            reasons |= dict.fromkeys(shown[1].split("-"), value.strip())
    return ExerciseDraft(
        **texts,
        hints=tuple(_text_field(fields, f"indice-{number}") for number in range(1, HINTS + 1)),
        checks=tuple(_with_tolerances(fields, tuple(_read_check_drafts(fields)), before)),
        mistakes=tuple(_read_mistake_drafts(fields)),
        reasons=dict([(name, reason) for name, reason in reasons.items() if reason][-MAX_REASONS:]),
    ).without_empty_parts()


def _text_field(fields: FormData, name: str) -> str:
    value = fields.get(name, "")
    return value.replace("\r\n", "\n") if isinstance(value, str) else ""


def _read_check_drafts(fields: FormData) -> Iterator[CheckDraft]:
    for at in range(ROOM * MAX_CHECKS):
        texts = {name: _text_field(fields, f"v-{at}-{field}") for name, field in _CHECK_TEXTS.items()}
        texts |= {name: texts[name] or usual for name, usual in CHECK_CHOICES.values()}
        flags = {name: _text_field(fields, f"v-{at}-{field}") == YES for name, field in _CHECK_FLAGS.items()}
        yield CheckDraft(**texts, **flags, cases=tuple(_read_case_drafts(fields, at)))  # type: ignore[arg-type]


def _with_tolerances(fields: FormData, checks: tuple[CheckDraft, ...], before: ExerciseDraft) -> Iterator[CheckDraft]:
    """Yield the checks with the tolerances that are typed beside the trial's answers, where they change what was."""
    for at, check in enumerate(checks):
        was = before.checks[at].tolerance if at < len(before.checks) else ""
        typed = fields.get(f"ecart-{at}")
        yield replace(check, tolerance=typed) if isinstance(typed, str) and typed != was else check


def read_picked_options(fields: FormData, name: str) -> frozenset[str]:
    """Return the values of the ticked proposals of this name."""
    return frozenset(value for value in fields.getlist(name) if isinstance(value, str))


def _read_case_drafts(fields: FormData, at: int) -> Iterator[CaseDraft]:
    for row in range(ROOM * MAX_CASES):
        case = CaseDraft(_text_field(fields, f"v-{at}-c-{row}-appel"), _text_field(fields, f"v-{at}-c-{row}-attendu"))
        if not case.is_empty:
            yield case


def _read_mistake_drafts(fields: FormData) -> Iterator[MistakeDraft]:
    for at in range(ROOM * MAX_MISTAKES):
        yield MistakeDraft(**{name: _text_field(fields, f"e-{at}-{field}") for name, field in _MISTAKE_TEXTS.items()})


def read_upload(fields: FormData) -> tuple[str, bytes]:
    """Return name and content of the file of the import; an empty one where there is none."""
    upload = fields.get("fichier")
    if not isinstance(upload, UploadFile) or not upload.filename:
        return "", b""
    return upload.filename, upload.file.read()
