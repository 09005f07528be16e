"""`balise check --fairness DIR`: how fair and how telling are the verdicts on programs that the graders do not know?

`DIR/<slug>/right/*.py` must get full marks, `DIR/<slug>/wrong/*.py` must not; the first line of each file says, as a
comment, what it does or what its mistake is. Each is graded in the real sandbox on several seeds: points that change
with the seed are a fault, unless the program draws by itself (the kit's generator has another seed in each grading, and
one of its own has none): those are counted apart, known by their name, `hasard`. Names are those that a student
reads in the end: the places that are searched after the verdict are joined on the first seed.

Whether a name is the right one is judged by whoever reads the last table, and kept in the file's second line:
`# nom: identifiant, …`, the names that would be right, or `# nom: aucun`, none would be.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

from graders.core.code.probe_runs import CHANCE
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import Verdict
from server.behaviour.limits import SEARCH_PROCESSOR_SECONDS
from server.cli import CommandError
from server.client.program.report import format_number
from server.course import Course, Exercise
from server.grading.sandbox_grader import SandboxGrader

#: The first of the seeds that follow one another: the same at each run, so that two runs compare.
FIRST_SEED = 2026
AT_ONCE = 2
FOLDERS = ("right", "wrong")
JUDGED = "# nom:"
NONE = "aucun"


@dataclass(frozen=True)
class FairnessSubmission:
    """A program of the folder; `names` are those that a reader held right, None where nobody has judged."""

    exercise: Exercise
    path: Path
    right: bool
    said: str
    names: frozenset[str] | None

    @property
    def source(self) -> bytes:
        return self.path.read_bytes()


@dataclass(frozen=True)
class GradedProgram:
    """The verdicts of one program, seed by seed."""

    submission: FairnessSubmission
    verdicts: Sequence[Verdict]

    @property
    def is_accepted(self) -> bool:
        """Full marks on some seed, for a wrong one; on all of them, for a right one."""
        full = [verdict.outcome is Outcome.OK for verdict in self.verdicts]
        return all(full) if self.submission.right else any(full)

    @property
    def has_grading_failed(self) -> bool:
        """Whether the grading itself failed."""
        return any(not verdict.outcome.counts for verdict in self.verdicts)

    @property
    def points_by_seed(self) -> list[float]:
        return sorted({verdict.points for verdict in self.verdicts})

    @property
    def is_mark_seed_dependent(self) -> bool:
        """Whether the mark depends on the seed, though the program draws nothing itself."""
        return len(self.points_by_seed) > 1 and not self.draws_at_random

    @property
    def draws_at_random(self) -> bool:
        """Whether the program draws at random, as its name tells on every seed."""
        return all(name == CHANCE for name in self.diagnosis_by_seed)

    @property
    def diagnosis_by_seed(self) -> list[str]:
        """The name given on each seed."""
        return [verdict.misconception or NONE for verdict in self.verdicts]

    @property
    def is_misdiagnosed(self) -> bool:
        """Whether a name is given that a reader judged wrong."""
        names = self.submission.names
        return names is not None and bool(set(self.diagnosis_by_seed) - names - {NONE})

    @property
    def is_always_diagnosed(self) -> bool:
        """Whether a misconception is named on every seed, and none of the names was judged wrong."""
        return NONE not in self.diagnosis_by_seed and not self.is_misdiagnosed


def run_fairness_check(
    course: Course, grader: SandboxGrader, folder: Path, seeds: int, only: Collection[str] = ()
) -> int:
    """Grades and tells; 1 when a right program is refused, a wrong one accepted, or a mark depends on the seed.

    `only` holds the exercises to which it is restricted, if any.
    """
    submissions = [
        submission for submission in read_submissions(course, folder) if not only or submission.exercise.id in only
    ]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        findings = []
        for finding in pool.map(lambda submission: grade_on_seeds(grader, submission, seeds), submissions):
            print(program_result_line(finding), flush=True)
            findings.append(finding)
    wrong = [finding for finding in findings if not finding.submission.right]
    print("\nErreur annoncée → nom donné")
    for finding in wrong:
        print(diagnosis_judgement_line(finding))
    print()
    for text in summary_lines(findings):
        print(text)
    faults = (f.is_mark_seed_dependent or f.has_grading_failed or f.is_accepted != f.submission.right for f in findings)
    return 1 if any(faults) else 0


def read_submissions(course: Course, folder: Path) -> Iterator[FairnessSubmission]:
    """The programs of a folder. Raises CommandError for a folder that holds none, or is no exercise's."""
    homes = [home for home in sorted(folder.glob("*")) if home.is_dir()]
    found = 0
    for home in homes:
        exercise = _find_exercise_of_folder(course, home)
        for side in FOLDERS:
            for path in sorted((home / side).glob("*.py")):
                found += 1
                yield _read_submission(exercise, path, right=side == "right")
    if not found:
        raise CommandError(f"« {folder} » ne contient aucun fichier EXERCICE/right/*.py ou EXERCICE/wrong/*.py.")


def _find_exercise_of_folder(course: Course, home: Path) -> Exercise:
    """Return the exercise that a folder is named after."""
    matching = [exercise for exercise in course.exercises.values() if exercise.id.split("/")[-1] == home.name]
    if len(matching) != 1:
        raise CommandError(f"« {home} » ne porte le nom d’aucun exercice, ou celui de plusieurs.")
    return matching[0]


def _read_submission(exercise: Exercise, path: Path, *, right: bool) -> FairnessSubmission:
    first, second, *_ = [*path.read_text(encoding="utf-8", errors="replace").splitlines()[:2], "", ""]
    names = None
    if second.startswith(JUDGED):
        names = frozenset(name.strip() for name in second.removeprefix(JUDGED).split(","))
    return FairnessSubmission(exercise, path, right, first.lstrip("# ").strip(), names)


def grade_on_seeds(grader: SandboxGrader, submission: FairnessSubmission, seeds: int) -> GradedProgram:
    source = submission.source
    verdicts = [
        grader.grade(submission.exercise.id, source, seed).verdict for seed in range(FIRST_SEED, FIRST_SEED + seeds)
    ]
    diagnosis = grader.locate_mistakes(submission.exercise.id, source, verdicts[0], seconds=SEARCH_PROCESSOR_SECONDS)
    return GradedProgram(submission, [replace(verdicts[0], diagnosis=diagnosis), *verdicts[1:]])


def program_result_line(finding: GradedProgram) -> str:
    """« ✗ poses wrong/x.py : accepté, 20 points ; nom : aucun — what its first line says »."""
    submission = finding.submission
    well = (
        finding.is_accepted == submission.right
        and not finding.is_mark_seed_dependent
        and not finding.has_grading_failed
    )
    judged = "correction échouée" if finding.has_grading_failed else "accepté" if finding.is_accepted else "refusé"
    points = " ou ".join(format_number(value) for value in finding.points_by_seed)
    varying = ", selon la graine" if finding.is_mark_seed_dependent else ""
    names = "" if submission.right else f" ; nom : {_format_given_names(finding)}"
    where = f"{submission.exercise.id.split('/')[-1]} {submission.path.parent.name}/{submission.path.name}"
    return f"{'✓' if well else '✗'} {where} : {judged}, {points} points{varying}{names} — {submission.said}"


def _format_given_names(finding: GradedProgram) -> str:
    """Return the name given, or those given in turn."""
    return " | ".join(dict.fromkeys(finding.diagnosis_by_seed))


def diagnosis_judgement_line(finding: GradedProgram) -> str:
    """« slug file: mistake said → name given (its title) », with the judgement of a reader."""
    submission = finding.submission
    titles = dict.fromkeys(v.diagnosis.title for v in finding.verdicts if v.diagnosis)
    title_text = f" ({' | '.join(titles)})" if titles else ""
    judged = "" if submission.names is None else " [jugé faux]" if finding.is_misdiagnosed else " [jugé]"
    slug = submission.exercise.id.split("/")[-1]
    return f"{slug} {submission.path.name} : {submission.said} → {_format_given_names(finding)}{title_text}{judged}"


def summary_lines(findings: Iterable[GradedProgram]) -> Iterator[str]:
    """How many names a reader judged wrong, where one did; then the line that programs read."""
    findings = list(findings)
    right = [f for f in findings if f.submission.right]
    wrong = [f for f in findings if not f.submission.right]
    judged = [f for f in wrong if f.submission.names is not None]
    if judged:
        yield f"misnamed={sum(f.is_misdiagnosed for f in judged)}/{len(judged)}"
    drawing = [f for f in findings if f.draws_at_random]
    if drawing:
        yield f"random={len(drawing)}/{len(findings)}"
    counts = {
        "refused": (sum(not f.is_accepted for f in right), len(right)),
        "accepted": (sum(f.is_accepted for f in wrong), len(wrong)),
        "named": (sum(f.is_always_diagnosed for f in wrong), len(wrong)),
        "varying": (sum(f.is_mark_seed_dependent for f in findings), len(findings)),
    }
    yield " ".join(f"{name}={some}/{all_}" for name, (some, all_) in counts.items())
