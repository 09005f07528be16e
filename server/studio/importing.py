"""Files of exercises made elsewhere, as drafts of a teacher's library: nothing of a file is ever run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from server.studio.archive import ArchiveRefused, holds_declared_exercise, read_archive, read_check, unpack_texts
from server.studio.dodona import has_suite, read_exercise
from server.studio.drafts import MAX_CASES, MAX_CHECKS, CaseDraft, CheckDraft, ExerciseDraft
from server.studio.import_drafts import NO_SOLUTION, ImportDraft, ImportRefused
from server.studio.imports import read_drafts

#: Exercises made of one file.
MAX_IMPORTED = 20
TOO_MANY = "{count} exercices dans ce fichier ; les {most} premiers sont lus"


@dataclass(frozen=True)
class ImportedExercise:
    """An imported draft with its three lists; without cases, nothing is made of it."""

    draft: ExerciseDraft
    understood: Sequence[str]
    to_look_at: Sequence[str]
    left: Sequence[str]

    @property
    def is_usable(self) -> bool:
        return any(check.nonempty_cases or check.draws for check in self.draft.checks)


def import_exercise_file(name: str, data: bytes) -> list[ImportedExercise]:
    """Return the exercises of a file, by the ending of its name. Raises ImportRefused."""
    if name.lower().endswith(".zip"):
        try:
            texts = unpack_texts(data)
            if has_suite(texts) and not holds_declared_exercise(texts):
                return [_finish_import(draft) for draft in read_exercise(texts)]
            draft = read_archive(texts)
        except ArchiveRefused as refused:
            raise ImportRefused(str(refused)) from refused
        calls = [case.call for check in draft.checks for case in check.nonempty_cases]
        return [ImportedExercise(draft, calls, (), ())]
    drafts = read_drafts(name, data)
    imported = [_finish_import(draft) for draft in drafts[:MAX_IMPORTED]]
    if len(drafts) > MAX_IMPORTED:
        words = TOO_MANY.format(count=len(drafts), most=MAX_IMPORTED)
        imported.append(ImportedExercise(ExerciseDraft(title=name), (), (), (words,)))
    return imported


def _finish_import(draft: ImportDraft) -> ImportedExercise:
    left = list(draft.left)
    checks = [_limit_cases(read_check(check), left) for check in draft.checks[:MAX_CHECKS]]
    left += [
        f"{check['titre']} : un exercice a {MAX_CHECKS} vérifications au plus" for check in draft.checks[MAX_CHECKS:]
    ]
    exercise = ExerciseDraft(
        title=draft.title,
        statement=draft.statement,
        functions=" ".join(draft.functions),
        solution=draft.solution or NO_SOLUTION,
        checks=tuple(checks) or (CheckDraft(),),
    )
    return ImportedExercise(exercise, draft.understood, draft.to_look_at, left)


def _limit_cases(check: CheckDraft, left: list[str]) -> CheckDraft:
    """Return a check with as many cases as one may have; what is beyond them is told in `left`."""
    beyond: Sequence[CaseDraft] = check.cases[MAX_CASES:]
    left += [f"{case.call[:80]} : « {check.title} » a déjà {MAX_CASES} cas, le plus possible" for case in beyond]
    values: dict[str, Any] = {**check.__dict__, "cases": check.cases[:MAX_CASES]}
    return CheckDraft(**values)
