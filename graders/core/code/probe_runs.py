"""Runs of probes on a student's program: with its own exchanges, or on a fresh launch; what repeated calls tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from graders.core.code.probes import ProbeAnswer, Probes, same_probe_answer
from graders.core.code.runner import Runner
from graders.core.code.shared_results import find_changed_result
from graders.core.contract.program import KitSettings, PlannedCalls, StudentFault, flatten_blocks

#: The slips of a function that answers the same call differently: by state that it keeps, or at random.
MEMORY, CHANCE = "memoire", "hasard"
OTHER_SEED = 1


def read_piggybacked(
    runner: Runner, probed: Sequence[Probes], batches: Sequence[PlannedCalls]
) -> list[list[ProbeAnswer]]:
    """Return the piggybacked answers of a stateless program; [] where there are none, or it seems to keep state."""
    answers_by_batch = [
        runner.piggybacked_answers(batch) if runner.is_callable(batch.function) else () for batch in batches
    ]
    if any(answers is None for answers in answers_by_batch):
        return []
    results = [
        [probes.read_answer(args, answer) for args, answer in zip(batch.calls, answers or (), strict=False)]
        for probes, batch, answers in zip(probed, batches, answers_by_batch, strict=True)
    ]
    return [] if any(map(repeat_differs, probed, results)) else results


def probe_side_program(
    runner: Runner, probed: Sequence[Probes], all_batches: Sequence[PlannedCalls], kit: KitSettings, deadline: float
) -> list[list[ProbeAnswer]]:
    """Return the answers of a fresh launch to these probes, which travel with its file; [] when it does not start.

    The answers end at a fatal fault or at the deadline.
    """
    results: list[list[ProbeAnswer]] = [[] for _ in probed]
    callable_indices = [index for index, batch in enumerate(all_batches) if runner.is_callable(batch.function)]
    batches = [all_batches[index] for index in callable_indices]
    try:
        with runner.side_program(kit, batches) as program:
            for number, answer in flatten_blocks(program.call_batches(batches)):
                index, function = callable_indices[number], batches[number].function
                runner.count_answer(program, function, answer)
                if runner.clock() > deadline or (isinstance(answer, StudentFault) and answer.fatal):
                    break
                args = batches[number].calls[len(results[index])]
                results[index].append(probed[index].read_answer(args, answer))
    except StudentFault:
        return []
    return results


def changes_returned_results(runner: Runner, probes: Probes) -> bool:
    """Whether a fresh launch, asked these probes, changes what it returned to one of them at the next."""
    batch = PlannedCalls(probes.function, probes.calls, return_arguments=True)
    try:
        with runner.side_program(probes.kit, [batch]) as program:
            answers = [answer for _, answer in flatten_blocks(program.call_batches([batch]))]
    except StudentFault:
        return False
    return find_changed_result(probes.calls, answers) is not None


def with_other_seed(kit: KitSettings) -> KitSettings:
    return replace(kit, parameters={**kit.parameters, "seed": OTHER_SEED})


def repeat_differs(probes: Probes, answers: Sequence[ProbeAnswer]) -> bool:
    """Whether the first call, repeated after the others, gets another answer."""
    return not probes.random and len(answers) > len(probes.calls) and not same_probe_answer(answers[-1], answers[0])


def find_state_slip(answers: Sequence[ProbeAnswer], again: Sequence[ProbeAnswer]) -> str | None:
    """Return the slip of a program that answered a repeated call differently, given the answers `again` of another
    launch; None when these are incomplete."""
    if len(again) < len(answers):
        return None
    return (
        MEMORY
        if all(same_probe_answer(first, second) for first, second in zip(answers, again, strict=True))
        else CHANCE
    )
