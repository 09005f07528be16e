"""Turns: round the lines, then round their senders; whoever comes waits for one of each other's, never for a heap."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from uuid import uuid4

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sqlalchemy import delete, select, text

from server.base.http import visitor_key
from server.database import Database
from server.identity.models import Account, Role
from server.queue.interfaces import BacklogLimits, Lease, NullNotifier, QueueFullError, Sender
from server.queue.lease_owner import process_owner
from server.queue.models import Job
from server.queue.service import TableQueue
from server.submissions.queue_senders import sender_of_account
from tests.support.counting import Counted

HERE, KIND = process_owner(os.getpid()), "bake"
QUEUE = TableQueue(NullNotifier())


def guest(name: str, address: str = "192.0.2.1") -> Sender:
    return Sender(name, address, flow=address, rank=1)


def member(name: str, address: str = "192.0.2.1") -> Sender:
    return Sender(name, address, flow=name)


@dataclass
class Bakery:
    """A queue whose jobs are named after their senders: `a#0`, `a#1`…"""

    database: Database
    sent: Counter[str] = field(default_factory=Counter)

    def put(self, sender: Sender, count: int = 1, most: BacklogLimits | None = None) -> list[str]:
        keys = [f"{sender.name}#{self.sent[sender.name] + k}" for k in range(count)]
        self.sent[sender.name] += count
        with self.database.write() as db:
            for key in keys:
                QUEUE.enqueue(db, KIND, key, {}, sender, most)
        return keys

    def claim(self) -> Lease | None:
        with self.database.write() as db:
            return QUEUE.claim(db, HERE, [KIND], 60)

    def finish(self, lease: Lease) -> None:
        with self.database.write() as db:
            assert QUEUE.finish(db, lease)

    def take(self) -> str | None:
        """Claims and ends the next."""
        lease = self.claim()
        if lease is None:
            return None
        self.finish(lease)
        return lease.key

    def served(self, tries: int | None = None) -> list[str]:
        """Take the next so many times, or until there is none left."""
        taken = iter(self.take, None) if tries is None else (self.take() for _ in range(tries))
        return [key for key in taken if key is not None]

    def places(self, keys: Iterable[str]) -> list[int | None]:
        with self.database.read() as db:
            return [QUEUE.position(db, KIND, key) for key in keys]


@pytest.fixture
def bakery(sqlite: Database) -> Bakery:
    return Bakery(sqlite)


@pytest.fixture
def either(database: Database) -> Bakery:
    """On SQLite, then on PostgreSQL."""
    return Bakery(database)


def who(keys: Iterable[str]) -> str:
    return "".join(key.partition("#")[0] for key in keys)


def test_backlogs_of_three_guests_delay_others_by_one_turn_at_most(either: Bakery) -> None:
    """The measured case: sixty submissions of three guests of one address, as two workers have begun."""
    for name in "abc":
        either.put(guest(name), 20)
    assert who(key for key in either.served(6)) == "abcabc"
    running = [either.claim(), either.claim()]
    (other,) = either.put(guest("o", "198.51.100.7"))
    (neighbour,) = either.put(guest("n"))
    (ada,) = either.put(member("A"))
    assert either.places([ada, other, neighbour]) == [1, 2, 4]
    assert all(running)
    assert who(either.served(6)) == "Aocnab"
    assert Counter(who(either.served(6))) == Counter(a=2, b=2, c=2)


def test_a_newcomer_goes_before_the_second_job_of_the_flow_that_is_served(either: Bakery) -> None:
    either.put(member("a"), 3)
    running = either.claim()
    either.put(member("b"))
    assert running is not None
    either.finish(running)
    assert who(either.served()) == "baa"


def test_newcomers_one_after_the_other_do_not_starve_a_flow(bakery: Bakery) -> None:
    bakery.put(member("a"), 3)
    order = []
    for name in "bcdefg":
        running = bakery.claim()
        bakery.put(member(name))
        assert running is not None
        bakery.finish(running)
        order.append(running.key)
    assert who([*order, *bakery.served()]) == "abacdeafg"


def test_a_heap_gives_every_second_turn_to_whoever_comes_back(bakery: Bakery) -> None:
    bakery.put(member("a"), 4)
    order = []
    for _ in range(3):
        bakery.put(member("b"))
        order += bakery.served(2)
    assert who([*order, *bakery.served()]) == "abababa"


def test_lines_of_one_length_alternate_and_each_keeps_its_own_order(bakery: Bakery) -> None:
    for name in "ab":
        bakery.put(member(name), 3)
    bakery.put(guest("g"), 2)
    assert bakery.served() == ["a#0", "b#0", "a#1", "b#1", "a#2", "b#2", "g#0", "g#1"]


def test_places_are_the_order_in_which_jobs_begin(bakery: Bakery) -> None:
    keys = [
        *bakery.put(guest("a"), 3),
        *bakery.put(guest("b"), 2),
        *bakery.put(guest("c", "x")),
        *bakery.put(member("d")),
    ]
    places = dict(zip(keys, bakery.places(keys), strict=True))
    assert bakery.served() == sorted(keys, key=lambda key: places[key] or 0)
    assert sorted(place or 0 for place in places.values()) == list(range(1, 8))


def test_requeued_job_keeps_its_turn(bakery: Bakery) -> None:
    bakery.put(member("a"), 2)
    bakery.put(member("b"))
    lease = bakery.claim()
    assert lease is not None
    with bakery.database.write() as db:
        QUEUE.requeue_untried(db, lease)
    assert who(bakery.served()) == "aba"


SENDERS = [member("A"), member("B"), *(guest(name, address) for name, address in ("ax", "bx", "cx", "dy", "ez"))]


@settings(max_examples=10)
@given(st.lists(st.one_of(st.sampled_from(SENDERS), st.just(None), st.just(0)), max_size=40), st.integers(1, 2))
def test_sender_without_backlog_never_waits_for_two_jobs_of_another(
    steps: list[Sender | int | None], workers: int
) -> None:
    """Of each other line of one's rank, and of each other sender of one's line, at most one begins before one does."""
    field_of.step_through(steps, workers)


class Field:
    """One database for all that hypothesis tries."""

    def __init__(self) -> None:
        self.database: Database | None = None

    def step_through(self, steps: list[Sender | int | None], workers: int) -> None:
        assert self.database is not None
        with self.database.write() as db:
            db.execute(delete(Job))
        bakery, running = Bakery(self.database), list[Lease]()
        senders = {sender.name: sender for sender in SENDERS}
        waiting: dict[str, int] = Counter()
        ahead: dict[str, tuple[Counter[str], Counter[str]]] = {}  # of who waits for a first: lines and senders passed
        for step in [*steps, *[None, 0] * (len(steps) + 1)]:
            if isinstance(step, Sender):
                alone = not any(waiting[one.name] for one in SENDERS if one.flow == step.flow)
                (key,) = bakery.put(step)
                if not waiting[step.name]:
                    ahead[key] = (Counter() if alone else Counter({"": -1000}), Counter())
                waiting[step.name] += 1
            elif step == 0 or len(running) == workers:
                if running:
                    bakery.finish(running.pop(0))
            elif (lease := bakery.claim()) is not None:
                running.append(lease)
                begun = senders[lease.key.partition("#")[0]]
                waiting[begun.name] -= 1
                ahead.pop(lease.key, None)
                for key, (lines, names) in ahead.items():
                    mine = senders[key.partition("#")[0]]
                    assert begun.rank <= mine.rank
                    if begun.flow == mine.flow:
                        names[begun.name] += 1
                        assert names[begun.name] <= 1, (key, lease.key)
                    elif begun.rank == mine.rank and not lines[""]:
                        lines[begun.flow] += 1
                        assert lines[begun.flow] <= 1, (key, lease.key)
        assert not any(waiting.values()), "everybody has had their turns"


field_of = Field()


@pytest.fixture(autouse=True)
def _database_of_the_field(request: pytest.FixtureRequest) -> None:
    if request.function is test_sender_without_backlog_never_waits_for_two_jobs_of_another:
        field_of.database = request.getfixturevalue("sqlite")


def test_many_put_and_many_take_at_once_and_nothing_is_lost(either: Bakery) -> None:
    def put(name: str) -> list[str]:
        mine = Bakery(either.database)
        return [key for _ in range(4) for key in mine.put(guest(name))]

    def take(_: int) -> list[str]:
        return either.served(8)

    with ThreadPoolExecutor(3) as pool:
        taking, putting = pool.map(take, range(1)), pool.map(put, "ab")
        taken, sent = [key for keys in taking for key in keys], [key for keys in putting for key in keys]
    assert Counter([*taken, *either.served()]) == Counter(sent)


def test_a_heap_has_a_height_for_each_and_for_each_address_and_rank(either: Bakery) -> None:
    most = BacklogLimits(per_sender=2, per_address=3)
    either.put(guest("a"), 2, most)
    for refused, whose in (
        (guest("a"), "sender"),
        (member("A", "x"), None),
        (guest("b"), None),
        (guest("c"), "address"),
    ):
        if whose is None:
            either.put(refused, 1, most)
            continue
        with pytest.raises(QueueFullError) as full:
            either.put(refused, 1, most)
        assert full.value.scope == whose
    either.put(guest("c", "198.51.100.7"), 1, most)
    either.put(member("B"), 1, most)
    lease = either.claim()
    assert lease is not None
    assert lease.key.startswith("A#")
    either.served(2)
    either.put(guest("a"), 1, most)  # what has begun waits no more


def test_claiming_reads_an_index_in_order_and_putting_asks_once(sqlite: Database) -> None:
    bakery = Bakery(sqlite)
    bakery.put(member("a"), 3)
    with Counted(sqlite) as counted:
        bakery.put(member("b"))
        bakery.claim()
    assert [statement.split()[0] for statement in counted.statements] == ["SELECT", "INSERT", "UPDATE"]
    with sqlite.read() as db:
        told = db.execute(text(f"EXPLAIN QUERY PLAN {counted.statements[-1].replace('?', '1')}")).all()
    plan = " ".join(str(row[3]) for row in told)
    assert "ix_job_claim" in plan
    assert "TEMP B-TREE" not in plan


def test_an_account_has_turns_of_its_own_and_guests_those_of_their_address() -> None:
    ada, bob = (Account(id=uuid4(), role=role, name="…") for role in (Role.student, Role.teacher))
    one, two = (Account(id=uuid4(), role=Role.guest, name="…") for _ in range(2))
    at = "192.0.2.1"
    senders = [sender_of_account(account, at) for account in (ada, bob, one, two)]
    assert [sender.rank for sender in senders] == [1, 1, 2, 2]
    pupils = [sender_of_account(account, at, member=True) for account in (ada, one)]
    assert [sender.rank for sender in pupils] == [0, 0], "a class comes first"
    assert pupils[1].flow not in {at, pupils[0].flow}, "a line has one rank"
    assert len({sender.flow for sender in senders}) == 3
    assert senders[2].flow == senders[3].flow == at
    assert len({sender.name for sender in senders}) == 4


@pytest.mark.parametrize(
    ("address", "network"),
    [
        ("192.0.2.1", "192.0.2.1"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("2001:db8:1:2:ffff::1", "2001:db8:1:2::/64"),
        ("::ffff:192.0.2.1", "192.0.2.1"),
    ],
)
def test_addresses_of_one_network_count_as_one(address: str, network: str) -> None:
    assert guest_at(visitor_key(address)).flow == network


def test_what_the_limits_call_a_visitor_is_taken_as_it_is() -> None:
    assert guest_at("testclient").flow == "testclient"


def guest_at(address: str) -> Sender:
    return sender_of_account(Account(id=uuid4(), role=Role.guest, name="…"), address)


def test_jobs_are_read_back_with_their_sender(bakery: Bakery) -> None:
    bakery.put(guest("a"))
    with bakery.database.read() as db:
        job = db.execute(select(Job)).scalar_one()
    assert (job.sender, job.address, job.flow, job.priority) == ("a", "192.0.2.1", "192.0.2.1", 1)
