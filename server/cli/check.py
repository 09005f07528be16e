"""`balise check [MODULE|EXERCISE…]`: what a course's own tests run.

The texts are rendered; of each module, their figures are drawn, their cells run and their animations played, unless
only some exercises are selected for. For each exercise: the reference gets full marks, the starter does not, every
catalogued misconception ends, is rejected and named, each specimen gets the outcome of its folder, and the checks ask
what the contracts of the functions promise, with a fixed case for each edge that they list. What is known of answers
without code is tried on several deals. All this on all cores, told in one order. What was in order and is unchanged is
not tried again (see `remembered`).
"""

import logging
import secrets
import sys
import time
from argparse import Namespace
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import repeat
from pathlib import Path
from types import MappingProxyType

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.protocol import KnownSubmission
from graders.courses import COURSES, CURRICULUM, GRADERS
from graders.discovery import discover
from server.authoring import families, objectives, shapes
from server.cells import faults as cells
from server.cli import CommandError, alterations, check_cache, fairness, parallel
from server.cli.check_cache import CheckCache
from server.cli.exercise_faults import EXERCISE_FAULTS
from server.cli.local import find_exercise, load_unrendered_course, local_grader
from server.cli.sandboxes import require_safe_sandbox, start_probing_walls
from server.course import Course, Exercise, Module, Problem, load_course, retrievals
from server.course.closure import ImportGraph
from server.course.models import SEED_BITS
from server.figures import lessons
from server.grading.sandbox_grader import SandboxGrader
from server.replays import faults as replays

Judge = Callable[[Judgement], str]
#: The part that all texts are, of every course: they speak of each other.
TEXTS = "textes"

#: Seconds of the processor after which a program is stopped that is known to be stopped: which limit it is does not
#: matter, and those of some exercises are long.
ENDLESS_SECONDS = 0.5


@dataclass(frozen=True)
class KnownCase:
    """A submission that is known; `judge` says what is wrong with its judgement, or nothing.

    `write` gives it for a seed, and it is judged on `rounds` seeds. One that is `endless` is stopped sooner than the
    others.
    """

    subject: str
    write: Callable[[int], bytes]
    judge: Judge
    rounds: int = 1
    endless: bool = False


@dataclass(frozen=True)
class CaseExamination:
    """One line of the table; `fault` is empty when all is well."""

    exercise: str
    subject: str
    fault: str
    seed: int


Told = CaseExamination | Sequence[Problem]
Job = Callable[[SandboxGrader], Told]


def run(arguments: Namespace) -> int:
    logging.basicConfig(level=logging.WARNING, stream=sys.stderr)
    if arguments.fairness is not None:
        return _run_fairness(arguments)
    if arguments.mutants:
        return _run_mutants(arguments)
    return _check_courses(arguments)


@dataclass(frozen=True)
class CachedCheckPart:
    """A unit of the cache: `jobs` run unless all inputs behind `inputs_digest` are unchanged."""

    name: str
    inputs_digest: str
    jobs: Sequence[Job]


def _check_courses(arguments: Namespace) -> int:
    started = time.monotonic()
    cache = check_cache.open_cache(fresh=arguments.fresh, requested=arguments.remember)
    probing = None if cache else start_probing_walls(slow=False)  # with a cache, most often nothing is left to run
    course, faults = _load_course_and_count_faults(cache, arguments.course)
    modules, exercises = _select_modules_and_exercises(course, arguments.exercises)
    imports = ImportGraph(*COURSES.folders, memory=cache.imports)
    parts = [
        *map(_module_check_part, repeat(course), modules),
        *(_exercise_check_part(exercise, imports) for exercise in exercises),
    ]
    left = [part for part in parts if not _is_unchanged_since_success(cache, part)]
    if left:
        require_safe_sandbox(probing or start_probing_walls(slow=False))
    faults += _run_parts_and_count_faults(cache, course, left)
    cache.write_file()
    print(_summary_line(len(exercises), faults, time.monotonic() - started))
    return 1 if faults else 0


def _load_course_and_count_faults(cache: CheckCache, folder: Path | None) -> tuple[Course, int]:
    """Load all courses, or the one in a folder; return it and the number of faults of its texts.

    Texts are rendered only if they have changed since they were in order.
    """
    folders = COURSES.folders if folder is None else [folder.resolve()]
    name, inputs_digest = (
        (TEXTS if folder is None else f"{TEXTS} {folder.resolve()}"),
        check_cache.texts_digest(folders),
    )
    render = cache.last_passed_day_if_unchanged(name, inputs_digest) is None
    if folder is None:
        course = load_course(render=render, memory=cache.imports)
    else:
        discovery = discover(rooms=[folder.resolve() / GRADERS])
        course = load_course(folder.resolve() / CURRICULUM, discovery=discovery, render=render, memory=cache.imports)
    asked = (fault for module in course.modules.values() for fault in retrievals.find_question_faults(module))
    found = (
        *course.problems,
        *shapes.find_catalogue_faults(course),
        *objectives.find_objective_faults(course),
        *families.find_family_faults(course),
        *asked,
    )
    faults = sum(map(_print_fault, found))
    if not faults:
        cache.record_passed(name, inputs_digest)
    return course, faults


def _select_modules_and_exercises(course: Course, names: Sequence[str]) -> tuple[Sequence[Module], Sequence[Exercise]]:
    """Return the modules and exercises of these names, or all of them."""
    modules = [course.modules[name] for name in names or course.modules if name in course.modules]
    selected = {exercise.id: exercise for module in modules for exercise in module.exercises}
    selected |= {name: find_exercise(course, name) for name in names if name not in course.modules}
    return modules, list(selected.values())


def _module_check_part(course: Course, module: Module) -> CachedCheckPart:
    alone = replace(course, modules=MappingProxyType({module.slug: module}))
    return CachedCheckPart(
        module.slug,
        check_cache.module_digest(module),
        [partial(check_part, alone) for check_part in (_find_drawing_faults, _find_failing_cells, _find_replay_faults)],
    )


def _exercise_check_part(exercise: Exercise, imports: ImportGraph) -> CachedCheckPart:
    return CachedCheckPart(
        exercise.id,
        check_cache.exercise_digest(exercise, imports),
        [
            *(partial(_examine_with_fresh_seed, exercise, case) for case in list_cases(exercise)),
            *(partial(faults, exercise) for faults in EXERCISE_FAULTS),
        ],
    )


def _is_unchanged_since_success(cache: CheckCache, part: CachedCheckPart) -> bool:
    """Whether it was in order, and is unchanged; says so."""
    day = cache.last_passed_day_if_unchanged(part.name, part.inputs_digest)
    if day is not None:
        print(f"✓ {part.name:<24} inchangé depuis le {day}", flush=True)
    return day is not None


def _run_parts_and_count_faults(cache: CheckCache, course: Course, parts: Sequence[CachedCheckPart]) -> int:
    """Tries all that is left, and keeps what is in order; how many faults there are."""
    if not parts:
        return 0
    jobs = [(part, job) for part in parts for job in part.jobs]
    faults = Counter[str]()
    results = parallel.run_in_order(course, _run_job, [job for _, job in jobs], "Vérification", _exercise_of_job)
    for (part, _), told in zip(jobs, results, strict=True):
        faults[part.name] += _print_fault(told) if isinstance(told, CaseExamination) else sum(map(_print_fault, told))
    for part in parts:
        if not faults[part.name]:
            cache.record_passed(part.name, part.inputs_digest)
    return faults.total()


def _run_job(grader: SandboxGrader, job: Job) -> Told:
    return job(grader)


def _exercise_of_job(job: Job) -> object:
    """An exercise's jobs go together: what it computes once, one process computes."""
    assert isinstance(job, partial)
    return job.args[0].id if job.func in (_examine_with_fresh_seed, *EXERCISE_FAULTS) else id(job)


def _find_drawing_faults(course: Course, _: SandboxGrader) -> Sequence[Problem]:
    return [*lessons.find_drawing_faults(course)]


def _find_failing_cells(course: Course, _: SandboxGrader) -> Sequence[Problem]:
    return [*cells.find_failing_cells(course)]


def _find_replay_faults(course: Course, _: SandboxGrader) -> Sequence[Problem]:
    return [*replays.find_replay_faults(course)]


def _examine_with_fresh_seed(exercise: Exercise, case: KnownCase, grader: SandboxGrader) -> CaseExamination:
    """With a fresh seed."""
    return examine_case(grader, exercise, case, secrets.randbits(SEED_BITS))


def _run_fairness(arguments: Namespace) -> int:
    if not arguments.fairness.is_dir():
        raise CommandError(f"« {arguments.fairness} » n’est pas un dossier.")
    probing, course = start_probing_walls(slow=False), load_unrendered_course()
    with local_grader(course, probing) as grader:
        only = {find_exercise(course, name).id for name in arguments.exercises}
        return fairness.run_fairness_check(course, grader, arguments.fairness, arguments.seeds, only)


def _run_mutants(arguments: Namespace) -> int:
    probing, course = start_probing_walls(slow=False), load_unrendered_course()
    selected = [find_exercise(course, name) for name in arguments.exercises]
    require_safe_sandbox(probing)
    return alterations.run(course, selected)


def _print_fault(result: CaseExamination | Problem) -> bool:
    """Print a result; return whether it is a fault."""
    if isinstance(result, Problem):
        print(f"✗ {result}", flush=True)
        return True
    mark = "✗" if result.fault else "✓"
    fault = f" — {result.fault} (graine {result.seed})" if result.fault else ""
    print(f"{mark} {result.exercise:<24} {result.subject}{fault}", flush=True)
    return bool(result.fault)


def _summary_line(exercises: int, faults: int, seconds: float) -> str:
    if faults:
        return f"{faults} problème{'s' if faults > 1 else ''}."
    return f"Tout est en ordre ({exercises} exercice{'s' if exercises > 1 else ''}, {seconds:.0f} s)."


def list_cases(exercise: Exercise) -> Iterator[KnownCase]:
    """Yield every known submission of an exercise, with its expected judgement."""
    reference, *others = (
        KnownCase(
            known.subject,
            known.source_for_seed,
            build_judge_of_known_submission(known),
            known.rounds,
            known.outcome is Outcome.TIMEOUT,
        )
        for known in exercise.grader.known_submissions()
    )
    yield reference
    yield KnownCase("fichier de départ", lambda _: exercise.starter.encode(), why_not_full_marks)
    yield from others


def build_judge_of_known_submission(known: KnownSubmission) -> Judge:
    """Return a judge of a known submission: it compares marks or outcome first, then the misconception."""
    marks = why_not_full_marks if known.outcome is None else judge_expecting_outcome(known.outcome)
    if known.diagnosis is None:
        return marks
    name = judge_expecting_misconception(known.diagnosis)
    return lambda judgement: marks(judgement) or name(judgement)


def examine_case(grader: SandboxGrader, exercise: Exercise, case: KnownCase, seed: int) -> CaseExamination:
    """Examine a case on `seed`, and on the following seeds for its other rounds."""
    policy = exercise.policy
    if case.endless:
        policy = replace(policy, cpu_seconds=min(policy.cpu_seconds, ENDLESS_SECONDS))
    for trial_seed in range(seed, seed + case.rounds):
        judgement = grader.grade(exercise.id, case.write(trial_seed), trial_seed, policy=policy)
        fault = case.judge(judgement) or unreplayable_films(exercise.id, judgement)
        if fault:
            return CaseExamination(exercise.id, case.subject, fault, trial_seed)
    return CaseExamination(exercise.id, case.subject, "", seed)


def unreplayable_films(exercise: str, judgement: Judgement) -> str:
    """The films of which no replay can be made."""
    from graders.scene.films import wire

    for check, film in judgement.films.items():
        try:
            wire(exercise, film, check)
        except Exception as error:  # whatever the author's function raises is reported with its place
            return f"le film de {check} ne se rejoue pas ({type(error).__name__}: {error})"
    return ""


def why_not_full_marks(judgement: Judgement) -> str:
    verdict = judgement.verdict
    if not verdict.outcome.counts:
        return "la correction a échoué"
    return "obtient tous les points" if verdict.outcome is Outcome.OK else ""


def judge_expecting_misconception(misconception: str) -> Judge:
    """Rejected, and named by its own id."""

    def judge(judgement: Judgement) -> str:
        diagnosis = judgement.verdict.diagnosis
        got = diagnosis.id if diagnosis else "aucun"
        return why_not_full_marks(judgement) or ("" if got == misconception else f"diagnostic obtenu : {got}")

    return judge


def judge_expecting_outcome(expected: Outcome) -> Judge:
    def judge(judgement: Judgement) -> str:
        got = judgement.verdict.outcome
        if got is expected:
            return ""
        failed = ", ".join(check.id for check in judgement.verdict.checks if not check.passed)
        return f"{expected.value} attendu, {got.value} obtenu" + (f" ({failed})" if failed else "")

    return judge
