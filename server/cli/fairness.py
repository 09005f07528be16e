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
from server.cli import CannotRun
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
    def accepted(self) -> bool:
        """Full marks on some seed, for a wrong one; on all of them, for a right one."""
        full = [verdict.outcome is Outcome.OK for verdict in self.verdicts]
        return all(full) if self.submission.right else any(full)

    @property
    def failed(self) -> bool:
        """Whether the grading itself failed."""
        return any(not verdict.outcome.counts for verdict in self.verdicts)

    @property
    def points(self) -> list[float]:
        return sorted({verdict.points for verdict in self.verdicts})

    @property
    def varies(self) -> bool:
        """Whether the mark depends on the seed, though the program draws nothing itself."""
        return len(self.points) > 1 and not self.random

    @property
    def random(self) -> bool:
        """Whether the program draws at random, as its name tells on every seed."""
        return all(name == CHANCE for name in self.names_given)

    @property
    def names_given(self) -> list[str]:
        """The name given on each seed."""
        return [verdict.misconception or NONE for verdict in self.verdicts]

    @property
    def misdiagnosed(self) -> bool:
        """Whether a name is given that a reader judged wrong."""
        names = self.submission.names
        return names is not None and bool(set(self.names_given) - names - {NONE})

    @property
    def always_diagnosed(self) -> bool:
        """Whether a misconception is named on every seed, and none of the names was judged wrong."""
        return NONE not in self.names_given and not self.misdiagnosed


def run(course: Course, grader: SandboxGrader, folder: Path, seeds: int, only: Collection[str] = ()) -> int:
    """Grades and tells; 1 when a right program is refused, a wrong one accepted, or a mark depends on the seed.

    `only` holds the exercises to which it is restricted, if any.
    """
    submissions = [
        submission for submission in read_submissions(course, folder) if not only or submission.exercise.id in only
    ]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        findings = []
        for finding in pool.map(lambda submission: grade_on_seeds(grader, submission, seeds), submissions):
            print(result_line(finding), flush=True)
            findings.append(finding)
    wrong = [finding for finding in findings if not finding.submission.right]
    print("\nErreur annoncée → nom donné")
    for finding in wrong:
        print(naming_line(finding))
    print()
    for text in summary(findings):
        print(text)
    faults = (f.varies or f.failed or f.accepted != f.submission.right for f in findings)
    return 1 if any(faults) else 0


def read_submissions(course: Course, folder: Path) -> Iterator[FairnessSubmission]:
    """The programs of a folder. Raises CannotRun for a folder that holds none, or is no exercise's."""
    homes = [home for home in sorted(folder.glob("*")) if home.is_dir()]
    found = 0
    for home in homes:
        exercise = _exercise(course, home)
        for side in FOLDERS:
            for path in sorted((home / side).glob("*.py")):
                found += 1
                yield _submission(exercise, path, right=side == "right")
    if not found:
        raise CannotRun(f"« {folder} » ne contient aucun fichier EXERCICE/right/*.py ou EXERCICE/wrong/*.py.")


def _exercise(course: Course, home: Path) -> Exercise:
    """Return the exercise that a folder is named after."""
    matching = [exercise for exercise in course.exercises.values() if exercise.id.split("/")[-1] == home.name]
    if len(matching) != 1:
        raise CannotRun(f"« {home} » ne porte le nom d’aucun exercice, ou celui de plusieurs.")
    return matching[0]


def _submission(exercise: Exercise, path: Path, *, right: bool) -> FairnessSubmission:
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


def result_line(finding: GradedProgram) -> str:
    """« ✗ poses wrong/x.py : accepté, 20 points ; nom : aucun — what its first line says »."""
    submission = finding.submission
    well = finding.accepted == submission.right and not finding.varies and not finding.failed
    judged = "correction échouée" if finding.failed else "accepté" if finding.accepted else "refusé"
    points = " ou ".join(format_number(value) for value in finding.points)
    varying = ", selon la graine" if finding.varies else ""
    names = "" if submission.right else f" ; nom : {_names(finding)}"
    where = f"{submission.exercise.id.split('/')[-1]} {submission.path.parent.name}/{submission.path.name}"
    return f"{'✓' if well else '✗'} {where} : {judged}, {points} points{varying}{names} — {submission.said}"


def _names(finding: GradedProgram) -> str:
    """Return the name given, or those given in turn."""
    return " | ".join(dict.fromkeys(finding.names_given))


def naming_line(finding: GradedProgram) -> str:
    """« slug file: mistake said → name given (its title) », with the judgement of a reader."""
    submission = finding.submission
    titles = dict.fromkeys(v.diagnosis.title for v in finding.verdicts if v.diagnosis)
    title_text = f" ({' | '.join(titles)})" if titles else ""
    judged = "" if submission.names is None else " [jugé faux]" if finding.misdiagnosed else " [jugé]"
    slug = submission.exercise.id.split("/")[-1]
    return f"{slug} {submission.path.name} : {submission.said} → {_names(finding)}{title_text}{judged}"


def summary(findings: Iterable[GradedProgram]) -> Iterator[str]:
    """How many names a reader judged wrong, where one did; then the line that programs read."""
    findings = list(findings)
    right = [f for f in findings if f.submission.right]
    wrong = [f for f in findings if not f.submission.right]
    judged = [f for f in wrong if f.submission.names is not None]
    if judged:
        yield f"misnamed={sum(f.misdiagnosed for f in judged)}/{len(judged)}"
    drawing = [f for f in findings if f.random]
    if drawing:
        yield f"random={len(drawing)}/{len(findings)}"
    counts = {
        "refused": (sum(not f.accepted for f in right), len(right)),
        "accepted": (sum(f.accepted for f in wrong), len(wrong)),
        "named": (sum(f.always_diagnosed for f in wrong), len(wrong)),
        "varying": (sum(f.varies for f in findings), len(findings)),
    }
    yield " ".join(f"{name}={some}/{all_}" for name, (some, all_) in counts.items())
