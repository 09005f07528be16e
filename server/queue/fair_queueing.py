"""Fair queueing of jobs. The turn of a job is computed once, as it is enqueued; claiming reads an index in order.

Start-time fair queueing (Goyal, Vin and Cheng, 1996), where each job costs one turn, without memory of past service.
Jobs of a flow are two turns apart; a new flow starts one turn after the turn being served, hence before the second job
of every waiting flow. Nobody starves: turns grow as they are served. A flow of any length delays another by one turn.

Guests of one address share a flow: its senders alternate within it in the same way. A job that goes before others of
its flow takes the turn of the first of them, and each of those takes the turn of the next.

`server.base.turns` shares turns in the same way within one process; these rows outlive the process.
"""

from dataclasses import dataclass

TURN_STEP = 2


@dataclass(frozen=True)
class FlowState:
    """Turns and backlog as a job is enqueued; None for a turn that does not exist.

    `served`, `first_waiting`: of its rank, the latest turn claimed and the first that waits. `last_of_flow`: of its
    flow, the last that waits. `own_*`: the same among the own turns of the flow's senders, then the last own turn of
    the sender that waits. The rest counts waiting jobs.
    """

    served: int | None
    first_waiting: int | None
    last_of_flow: int | None
    own_served: int | None
    own_first_waiting: int | None
    own_last_waiting: int | None
    own_last_of_sender: int | None
    waiting_of_sender: int
    waiting_from_address: int


@dataclass(frozen=True)
class FairTurn:
    """`flow` orders flows, `own` the senders of a flow. `pushes_back`: jobs of the flow with a later own turn wait."""

    flow: int
    own: int
    pushes_back: bool


def next_turn(state: FlowState) -> FairTurn:
    """Return the turn of a job enqueued now."""
    own = _start_tag(state.own_served, state.own_first_waiting, state.own_last_of_sender)
    return FairTurn(
        _start_tag(state.served, state.first_waiting, state.last_of_flow),
        own,
        pushes_back=state.own_last_waiting is not None and state.own_last_waiting > own,
    )


def _start_tag(served: int | None, first_waiting: int | None, previous: int | None) -> int:
    """Return the turn after `previous`; without one, right after the turn being served.

    The turn being served is unknown between two jobs, and too low while an old job still runs beside newer ones: then
    it is the one before the first that waits.
    """
    now = served or 0
    if first_waiting is not None and (served is None or first_waiting > served + TURN_STEP):
        now = first_waiting - 1
    return now + 1 if previous is None else max(now + 1, previous + TURN_STEP)
