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
from graders.core.declared.hunts import DeclaredHunt, DeclaredHuntGround, list_hunts, try_hunt
from server.base.caches import LRUCache
from server.grading.sandbox_grader import SandboxPrograms
from server.hunts.protocol import (
    GONE,
    MAX_OFFERS,
    OUTSIDE,
    Argument,
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
class KnownDeclaredHunt:
    """A hunt and the arguments of its witness, as one types them; None where it has none."""

    hunt: DeclaredHunt
    witness: tuple[str, ...] | None


class DeclaredHuntRunner:
    """Answers questions about hunts of declared exercises, whose declarations come with the questions."""

    def __init__(self, sandbox: Sandbox, policy: Policy) -> None:
        self._sandbox, self._policy = sandbox, policy
        self._known: LRUCache[tuple[str, HuntName], KnownDeclaredHunt] = LRUCache(MAX_KNOWN)

    def answer(self, question: HuntQuestion) -> HuntReply:
        """Answer one question. Raises SandboxFault when the fault is ours."""
        match question.hunts:
            case OfferRequest() as asked:
                return HuntReply(offer=self._offer(asked, question.declarations))
            case InputTrial() as trial:
                return HuntReply(outcome=self._try_input(trial, question.declarations))
        return HuntReply(outcome=HuntTrialOutcome(refusal=GONE))

    def _offer(self, asked: OfferRequest, declarations: Mapping[str, dict[str, Any]]) -> OfferedHunt | None:
        for index, name in enumerate(asked.hunts[:MAX_OFFERS]):
            for known in self._hunts_of(name, declarations.get(name.exercise)):
                if known.witness is not None:
                    return _describe(index, name, known.hunt, known.witness, asked.seed)
        return None

    def _hunts_of(self, name: HuntName, data: dict[str, Any] | None) -> Iterator[KnownDeclaredHunt]:
        """Yield the hunts of a mistake, with their witnesses."""
        if data is None:
            return
        version = json.dumps(data, sort_keys=True)
        grader = DeclaredGrader(name.exercise, read_declaration(data))
        for hunt in list_hunts(grader):
            if hunt.mistake.id != name.misconception or name.function not in ("", hunt.function):
                continue
            key = (f"{hunt.check.id} {version}", name.model_copy(update={"function": hunt.function}))
            known = self._known.get(key)
            yield known if known is not None else self._known.put(key, self._make(hunt))

    def _make(self, hunt: DeclaredHunt) -> KnownDeclaredHunt:
        try:
            with closing(DeclaredHuntGround(hunt, self._programs(hunt))) as ground:
                return KnownDeclaredHunt(hunt, ground.find_witness())
        except StudentFault:
            return KnownDeclaredHunt(hunt, None)

    def _programs(self, hunt: DeclaredHunt) -> Programs:
        return SandboxPrograms(self._sandbox, self._policy, asked=hunt.grader.functions)

    def _try_input(self, trial: InputTrial, declarations: Mapping[str, dict[str, Any]]) -> HuntTrialOutcome:
        hunts = self._hunts_of(trial.hunt, declarations.get(trial.hunt.exercise))
        known = next((each for each in hunts if each.witness is not None), None)
        if known is None or known.witness is None:
            return HuntTrialOutcome(refusal=GONE)
        try:
            case = known.hunt.read_input(trial.typed)
            shown = try_hunt(known.hunt, self._programs(known.hunt), case)
        except InputFault as fault:
            return HuntTrialOutcome(refusal=fault.message, argument=fault.argument)
        except (InputOutsideStatement, StudentFault):
            return HuntTrialOutcome(refusal=OUTSIDE)
        typed = sum(len(text.replace(" ", "")) for text in trial.typed.values())
        small = typed <= sum(len(text.replace(" ", "")) for text in known.witness)
        return HuntTrialOutcome(
            is_right=shown.shows, expected=shown.expected, got=shown.got, fault=shown.fault, small=small
        )


def _describe(index: int, name: HuntName, hunt: DeclaredHunt, witness: tuple[str, ...], seed: int) -> OfferedHunt:
    arguments = zip(hunt.arguments, witness, strict=True)
    return OfferedHunt(
        index=index,
        hunt=name.model_copy(update={"function": hunt.function}),
        title=hunt.mistake.title,
        program=hunt.program(seed),
        arguments=tuple(Argument(name=each.name, words=each.words, witness=text) for each, text in arguments),
        numbers=0,
        nonzero=0,
        predictable=False,
        returns="",
    )
