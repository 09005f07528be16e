"""Hunts in the process that runs cells: every program runs in the sandbox, plain values are compared here."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from graders import discovery
from graders.core.advice.trying import TIMED, review_program
from graders.core.code.exercise import CodeDefinition
from graders.core.code.hunts import (
    Hunt,
    HuntPrograms,
    InputFault,
    InputOutsideStatement,
    find_witness,
    list_hunts,
    measure_input,
)
from graders.core.code.wrong_lines import find_wrong_lines
from graders.core.compare.words import text
from graders.core.contract.program import Program, StudentFault
from graders.core.contract.values import Arguments, Value
from server.grading.sandbox_grader import SandboxPrograms
from server.hunts.declared import DeclaredHuntRunner
from server.hunts.protocol import (
    GONE,
    MAX_OFFERS,
    OUTSIDE,
    AnswerComparison,
    ComparedAnswer,
    ComparisonRequest,
    HuntArgument,
    HuntName,
    HuntQuestion,
    HuntReply,
    HuntTrialOutcome,
    InputTrial,
    LineTrial,
    OfferedHunt,
    OfferRequest,
    PredictionTrial,
    PreparationRequest,
    ProgramRemark,
    ProgramReview,
    ReviewRequest,
)
from server.hunts.typed_values import format_typed_argument, parse_typed_arguments, parse_typed_value
from server.sandbox import Policy, Sandbox

MIB = 1 << 20
POLICY = Policy(cpu_seconds=3.0, wall_seconds=5.0, memory_bytes=512 * MIB)
#: Other mistakes of a function whose answers are compared with the right one.
MAX_COMPARED = 6
#: Significant digits of compared answers: few, where these tell the right one from the wrong one.
FEW_DIGITS, MANY_DIGITS = (3, 4), 6
#: Numbers of an answer that one predicts, and how near the prediction must be.
MAX_PREDICTED, PREDICTION_TOLERANCE = 6, 0.011


@dataclass(frozen=True)
class HuntWithWitness:
    """A hunt with its witness, and what both programs answer to it."""

    hunt: Hunt
    witness: Arguments
    expected: Value
    got: Value


class HuntRunner:
    """Answers questions about hunts; the witnesses that it has found stay known."""

    def __init__(self, sandbox: Sandbox) -> None:
        self._sandbox = sandbox
        self._known: dict[HuntName, HuntWithWitness | None] = {}
        self._declared = DeclaredHuntRunner(sandbox, POLICY)

    def answer_question(self, question: HuntQuestion) -> HuntReply:
        """Answer one question. Raises SandboxFault when the fault is ours."""
        if any(name.exercise in question.declarations for name in _hunt_names_in_question(question)):
            return self._declared.answer_question(question)
        match question.hunts:
            case OfferRequest() as asked:
                return HuntReply(offer=self._offer_first_possible_hunt(asked))
            case ComparisonRequest() as asked:
                return HuntReply(comparison=self._compare_first_possible_hunt(asked))
            case ReviewRequest() as request:
                return HuntReply(review=self._review_program(request))
            case PreparationRequest():
                return HuntReply()
            case InputTrial() | PredictionTrial() | LineTrial() as trial:
                return HuntReply(outcome=self._try_answer(trial))

    def _try_answer(self, trial: InputTrial | PredictionTrial | LineTrial) -> HuntTrialOutcome:
        match trial:
            case InputTrial():
                return self._run_on_typed_input(trial)
            case PredictionTrial():
                return self._check_typed_prediction(trial)
            case LineTrial():
                return self._check_line_choice(trial)

    def _review_program(self, request: ReviewRequest) -> ProgramReview:
        """Try the remarks on a program beside it and the reference, in one run."""
        programs = SandboxPrograms(self._sandbox, POLICY)
        review = review_program(_load_code_definition(request.exercise), request.source, programs)
        remarks = tuple(
            ProgramRemark(
                line=tried.advice.line,
                sentence=tried.advice.sentence,
                before=tried.advice.before,
                after=tried.advice.after,
                gain=tried.gain if tried.advice.kind in TIMED else 0.0,
            )
            for tried in review.advice
        )
        return ProgramReview(remarks=remarks, ratio=review.ratio)

    def _offer_first_possible_hunt(self, request: OfferRequest) -> OfferedHunt | None:
        for index, name in enumerate(request.hunts[:MAX_OFFERS]):
            for hunt in _find_hunts_of_misconception(name):
                exact = HuntName(exercise=name.exercise, misconception=name.misconception, function=hunt.function)
                if (known := self._find_witness(exact, hunt)) is not None:
                    return _describe_offer(index, exact, known, request.seed)
        return None

    def _find_witness(self, name: HuntName, hunt: Hunt) -> HuntWithWitness | None:
        if name not in self._known:
            with self._open_right_and_wrong_programs(name, hunt) as (ground, wrong):
                witness = find_witness(hunt, ground, wrong)
                answer = None if witness is None else ground.try_input(hunt, wrong, witness)
            self._known[name] = (
                None
                if witness is None or answer is None
                else HuntWithWitness(hunt, witness, answer.expected, answer.got)
            )
        return self._known[name]

    def _check_line_choice(self, trial: LineTrial) -> HuntTrialOutcome:
        """Compare a line with those by which the program differs from a right one. Runs nothing."""
        definition, hunt = (
            _load_code_definition(trial.hunt.exercise),
            next(_find_hunts_of_misconception(trial.hunt), None),
        )
        public = sorted(definition.judged_functions)
        changed = None if hunt is None else find_wrong_lines(definition, hunt, trial.seed, public)
        if hunt is None or changed is None:
            return HuntTrialOutcome(refusal=GONE)
        lines = hunt.wrong_program_source(trial.seed, public).splitlines()
        if not 0 <= trial.line <= len(lines):
            return HuntTrialOutcome(refusal="Choisissez une ligne du programme.")
        wrong = "\n".join(lines[number - 1].strip() for number in changed.mending)
        mending = "\n".join(line.strip() for line in changed.mending.values())
        return HuntTrialOutcome(is_right=trial.line in changed.mending, expected=mending, got=wrong)

    def _compare_first_possible_hunt(self, request: ComparisonRequest) -> AnswerComparison | None:
        for index, name in enumerate(request.hunts[:MAX_OFFERS]):
            for hunt in _find_hunts_of_misconception(name):
                exact = HuntName(exercise=name.exercise, misconception=name.misconception, function=hunt.function)
                known = self._find_witness(exact, hunt)
                if known is not None and _is_few_finite_numbers(known.expected) and _is_few_finite_numbers(known.got):
                    return self._build_comparison(index, exact, known)
        return None

    def _build_comparison(self, index: int, name: HuntName, known: HuntWithWitness) -> AnswerComparison:
        digits = next((few for few in FEW_DIGITS if _are_answers_distinguishable(known, few)), MANY_DIGITS)
        given = zip(known.hunt.contract.takes, known.witness, strict=False)
        call = ", ".join(f"{argument}={format_typed_argument(value)}" for argument, value in given)
        return AnswerComparison(
            index=index,
            hunt=name,
            call=f"{name.function}({call})",
            right=text(known.expected, digits=digits),
            wrong=tuple(self._wrong_answers(name, known, digits)),
        )

    def _wrong_answers(self, name: HuntName, known: HuntWithWitness, digits: int) -> Iterator[ComparedAnswer]:
        """Yield what a few known mistakes of the function answer to a witness, that of the hunt first, each once."""
        got = text(known.got, digits=digits)
        told = {text(known.expected, digits=digits), got}
        yield ComparedAnswer(misconception=name.misconception, words=got)
        others = [hunt for hunt in _list_hunts_of_exercise(name.exercise) if hunt.function == known.hunt.function]
        with self._open_right_and_wrong_programs(name, known.hunt) as (ground, _):
            for other in others[:MAX_COMPARED]:
                with closing(ground.open(other.source)) as wrong:
                    answer = next(ground.try_inputs(other, wrong, [known.witness]))
                words = (
                    "" if answer is None or not _is_few_finite_numbers(answer.got) else text(answer.got, digits=digits)
                )
                if answer is not None and answer.shows and words and words not in told:
                    told.add(words)
                    yield ComparedAnswer(misconception=other.misconception.id, words=words)

    @contextmanager
    def _open_right_and_wrong_programs(self, name: HuntName, hunt: Hunt) -> Iterator[tuple[HuntPrograms, Program]]:
        """Open the right programs and the wrong one, and close them."""
        ground = HuntPrograms(_load_code_definition(name.exercise), SandboxPrograms(self._sandbox, POLICY))
        try:
            wrong = ground.open(hunt.source)
            try:
                yield ground, wrong
            finally:
                wrong.close()
        finally:
            ground.close()

    def _run_on_typed_input(self, trial: InputTrial) -> HuntTrialOutcome:
        hunt = next(_find_hunts_of_misconception(trial.hunt), None)
        if hunt is None or (known := self._find_witness(trial.hunt, hunt)) is None:
            return HuntTrialOutcome(refusal=GONE)
        try:
            args = hunt.read_input(parse_typed_arguments(trial.typed))
        except InputFault as fault:
            return HuntTrialOutcome(refusal=fault.message, argument=fault.argument)
        try:
            with self._open_right_and_wrong_programs(trial.hunt, hunt) as (ground, wrong):
                answer = ground.try_input(hunt, wrong, args)
        except (InputOutsideStatement, StudentFault):
            return HuntTrialOutcome(refusal=OUTSIDE)
        return HuntTrialOutcome(
            is_right=answer.shows,
            expected=text(answer.expected),
            got="" if answer.fault else text(answer.got),
            fault=answer.fault,
            small=_is_no_larger_than_witness(args, known.witness),
        )

    def _check_typed_prediction(self, trial: PredictionTrial) -> HuntTrialOutcome:
        hunt = next(_find_hunts_of_misconception(trial.hunt), None)
        if (
            hunt is None
            or (known := self._find_witness(trial.hunt, hunt)) is None
            or not _is_few_finite_numbers(known.got)
        ):
            return HuntTrialOutcome(refusal="Cette question n’existe plus : prenez-en une autre.")
        try:
            typed = np.asarray(parse_typed_value("valeur", trial.typed), dtype=np.float64)
        except InputFault as fault:
            return HuntTrialOutcome(refusal=fault.message, argument=fault.argument)
        except (TypeError, ValueError):
            return HuntTrialOutcome(refusal="Donnez des nombres, et une liste si la fonction en rend plusieurs.")
        right = _flatten_numbers(known.got)
        close = typed.size == right.size and bool(
            np.allclose(typed.ravel(), right, rtol=0.002, atol=PREDICTION_TOLERANCE)
        )
        return HuntTrialOutcome(is_right=close, expected=text(known.got), got=text(_scalar_or_array(typed)))


def _hunt_names_in_question(question: HuntQuestion) -> Sequence[HuntName]:
    """Return the hunts that a question is about."""
    if isinstance(question.hunts, ReviewRequest | PreparationRequest):
        return ()
    if isinstance(question.hunts, OfferRequest | ComparisonRequest):
        return question.hunts.hunts
    return (question.hunts.hunt,)


def _are_answers_distinguishable(known: HuntWithWitness, digits: int) -> bool:
    return text(known.expected, digits=digits) != text(known.got, digits=digits)


def _scalar_or_array(typed: np.ndarray) -> Value:
    return float(typed) if typed.shape == () else typed


def _describe_offer(index: int, name: HuntName, known: HuntWithWitness, seed: int) -> OfferedHunt:
    hunt, size, definition = known.hunt, measure_input(known.witness), _load_code_definition(name.exercise)
    public = sorted(definition.judged_functions)
    changed = find_wrong_lines(definition, hunt, seed, public)
    optional = {argument for argument, _ in hunt.contract.defaults}
    witness = dict(zip(hunt.contract.takes, map(format_typed_argument, known.witness), strict=False))
    return OfferedHunt(
        index=index,
        hunt=name,
        title=hunt.misconception.title,
        program=hunt.wrong_program_source(seed, public),
        arguments=tuple(
            HuntArgument(
                name=argument, words=form.description, witness=witness.get(argument, ""), optional=argument in optional
            )
            for argument, form in hunt.contract.takes.items()
        ),
        numbers=size.numbers,
        nonzero=size.nonzero,
        predictable=_is_few_finite_numbers(known.got),
        wrong_lines=0 if changed is None else len(changed.mending),
        returns=hunt.contract.returns.description,
    )


def _is_no_larger_than_witness(args: Arguments, witness: Arguments) -> bool:
    mine, known = measure_input(args), measure_input(witness)
    return mine.nonzero <= known.nonzero and mine.numbers <= known.numbers


def _is_few_finite_numbers(answer: Value) -> bool:
    """Whether an answer is a few finite numbers."""
    try:
        numbers = _flatten_numbers(answer)
    except (TypeError, ValueError):
        return False
    return 0 < numbers.size <= MAX_PREDICTED and bool(np.isfinite(numbers).all())


def _flatten_numbers(value: Value) -> np.ndarray:
    """Return the numbers of an answer in a row. Raises ValueError or TypeError for what holds anything else."""
    if isinstance(value, tuple | list):
        return np.concatenate([np.zeros(0), *map(_flatten_numbers, value)])
    return np.ravel(np.asarray(value, dtype=np.float64))


def _find_hunts_of_misconception(name: HuntName) -> Iterator[Hunt]:
    for hunt in _list_hunts_of_exercise(name.exercise):
        if hunt.misconception.id == name.misconception and name.function in ("", hunt.function):
            yield hunt


@lru_cache(maxsize=256)
def _list_hunts_of_exercise(exercise: str) -> tuple[Hunt, ...]:
    return tuple(list_hunts(_load_code_definition(exercise)))


def _load_code_definition(exercise: str) -> CodeDefinition:
    definition = discovery.load_definition(exercise)
    if not isinstance(definition, CodeDefinition):
        raise LookupError(f"{exercise} has no checks of code")
    return definition
