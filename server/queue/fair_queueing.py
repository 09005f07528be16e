"""When a job's turn comes, said once, as it is put: claiming is reading an index in order.

This is fair queueing by start tags (Goyal, Vin and Cheng, "Start-time fair queuing", 1996), where each job costs one
turn, without memory of who has been served. Those of a line are two turns apart; who joins comes one after the turn
that is being served, thus before the second of every line that waits, and nobody who joins later overtakes that for
ever: turns go up as they are served. So a line, however long, delays another by one turn.

A line may be shared (guests of one address): its senders take turns within it in the same way, and a job that comes
before others of its line takes the first one's turn, which each of them passes on to the next.

`server.base.concurrency` shares waiting time alike within one process; this module is for rows that outlive a process.
"""

from dataclasses import dataclass

APART = 2


@dataclass(frozen=True)
class Crowd:
    """What is there as a job comes; None for a turn of which there is none.

    Of its rank: the turn begun last and the first that waits. Of its line: the last that waits; the senders' own turns
    begun last, waiting first and last. Of its sender: the last own turn that waits. How many wait: of the sender, and
    from its address.
    """

    begun: int | None
    first: int | None
    line_last: int | None
    own_begun: int | None
    own_first: int | None
    own_last: int | None
    sender_last: int | None
    of_sender: int
    from_address: int


@dataclass(frozen=True)
class Turn:
    """`pushes`: others of the line, whose own turn is later, wait already, and have to be passed."""

    line: int
    own: int
    pushes: bool


def next_turn(crowd: Crowd) -> Turn:
    """The turn of who comes now."""
    own = _after(crowd.own_begun, crowd.own_first, crowd.sender_last)
    return Turn(
        _after(crowd.begun, crowd.first, crowd.line_last),
        own,
        pushes=crowd.own_last is not None and crowd.own_last > own,
    )


def _after(begun: int | None, first: int | None, mine: int | None) -> int:
    """After `mine`, or, for who has none, right after what is being served (just before the first that waits)."""
    now = max(0 if begun is None else begun, 0 if first is None else first - 1)
    return now + 1 if mine is None else max(now + 1, mine + APART)
