"""Hunts of declared exercises, in the process that runs cells: both programs run in the sandbox."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from typing import Any

from graders.core.code.hunts import InputFault, InputOutsideStatement
from graders.core.contract.program import Programs, StudentFault
from graders.core.declared.declaration import read_declaration
from graders.core.declared.grading import DeclaredGrader
from graders.core.declared.hunts import DeclaredHunt, DeclaredHuntPrograms, list_hunts, try_hunt
from server.base.caches import LRUCache
from server.grading.sandbox_grader import SandboxPrograms
from server.hunts.protocol import (
    GONE,
    MAX_OFFERS,
    OUTSIDE,
    HuntArgument,
    HuntName,
    HuntQuestion,
    HuntReply,
    HuntTrialOutcome,
    InputTrial,
    OfferedHunt,
    OfferRequest,
)
from server.sandbox import Policy, Sandbox

#: Hunts whose witness stays known.
MAX_KNOWN = 64


@dataclass(frozen=True)
class DeclaredHuntWithWitness:
    """A hunt and the arguments of its witness, as one types them; None where it has none."""

    hunt: DeclaredHunt
    witness: tuple[str, ...] | None


class DeclaredHuntRunner:
    """Answers questions about hunts of declared exercises, whose declarations come with the questions."""

    def __init__(self, sandbox: Sandbox, policy: Policy) -> None:
        self._sandbox, self._policy = sandbox, policy
        self._known: LRUCache[tuple[str, HuntName], DeclaredHuntWithWitness] = LRUCache(MAX_KNOWN)

    def answer_question(self, question: HuntQuestion) -> HuntReply:
        """Answer one question. Raises SandboxFault when the fault is ours."""
        match question.hunts:
            case OfferRequest() as asked:
                return HuntReply(offer=self._offer_first_possible_hunt(asked, question.declarations))
            case InputTrial() as trial:
                return HuntReply(outcome=self._run_on_typed_input(trial, question.declarations))
        return HuntReply(outcome=HuntTrialOutcome(refusal=GONE))

    def _offer_first_possible_hunt(
        self, request: OfferRequest, declarations: Mapping[str, dict[str, Any]]
    ) -> OfferedHunt | None:
        for index, name in enumerate(request.hunts[:MAX_OFFERS]):
            for known in self._find_hunts_of_misconception(name, declarations.get(name.exercise)):
                if known.witness is not None:
                    return _describe_offer(index, name, known.hunt, known.witness, request.seed)
        return None

    def _find_hunts_of_misconception(
        self, name: HuntName, declaration: dict[str, Any] | None
    ) -> Iterator[DeclaredHuntWithWitness]:
        """Yield the hunts of a mistake, with their witnesses."""
        if declaration is None:
            return
        version = json.dumps(declaration, sort_keys=True)
        grader = DeclaredGrader(name.exercise, read_declaration(declaration))
        for hunt in list_hunts(grader):
            if hunt.mistake.id != name.misconception or name.function not in ("", hunt.function):
                continue
            key = (f"{hunt.check.id} {version}", name.model_copy(update={"function": hunt.function}))
            known = self._known.get(key)
            yield known if known is not None else self._known.put(key, self._find_witness(hunt))

    def _find_witness(self, hunt: DeclaredHunt) -> DeclaredHuntWithWitness:
        try:
            with closing(DeclaredHuntPrograms(hunt, self._sandbox_programs(hunt))) as ground:
                return DeclaredHuntWithWitness(hunt, ground.find_witness())
        except StudentFault:
            return DeclaredHuntWithWitness(hunt, None)

    def _sandbox_programs(self, hunt: DeclaredHunt) -> Programs:
        return SandboxPrograms(self._sandbox, self._policy, asked=hunt.grader.functions)

    def _run_on_typed_input(self, trial: InputTrial, declarations: Mapping[str, dict[str, Any]]) -> HuntTrialOutcome:
        hunts = self._find_hunts_of_misconception(trial.hunt, declarations.get(trial.hunt.exercise))
        known = next((each for each in hunts if each.witness is not None), None)
        if known is None or known.witness is None:
            return HuntTrialOutcome(refusal=GONE)
        try:
            case = known.hunt.read_input(trial.typed)
            shown = try_hunt(known.hunt, self._sandbox_programs(known.hunt), case)
        except InputFault as fault:
            return HuntTrialOutcome(refusal=fault.message, argument=fault.argument)
        except (InputOutsideStatement, StudentFault):
            return HuntTrialOutcome(refusal=OUTSIDE)
        typed = sum(len(text.replace(" ", "")) for text in trial.typed.values())
        small = typed <= sum(len(text.replace(" ", "")) for text in known.witness)
        return HuntTrialOutcome(
            is_right=shown.shows, expected=shown.expected, got=shown.got, fault=shown.fault, small=small
        )


def _describe_offer(index: int, name: HuntName, hunt: DeclaredHunt, witness: tuple[str, ...], seed: int) -> OfferedHunt:
    arguments = zip(hunt.arguments, witness, strict=True)
    return OfferedHunt(
        index=index,
        hunt=name.model_copy(update={"function": hunt.function}),
        title=hunt.mistake.title,
        program=hunt.wrong_program_source(seed),
        arguments=tuple(HuntArgument(name=each.name, words=each.description, witness=text) for each, text in arguments),
        numbers=0,
        nonzero=0,
        predictable=False,
        returns="",
    )
