"""What a member of a class waits for, door by door, while nothing else goes on and while somebody attacks."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from statistics import median

import httpx

from tests.contract.gate.floods import FLOODS
from tests.contract.gate.service import EXERCISE, LOGIN, PASSWORD, Service

MODULE, SLUG = EXERCISE.split("/")
PAGES = (f"/{MODULE}", f"/{MODULE}/exercices/{SLUG}", "/classes")
#: Seconds that a flood goes on before somebody is measured, and for which its work may go on after it.
RUN_UP = 1.0
#: Seconds beyond which a door counts as closed.
CLOSED = 60.0


@dataclass(frozen=True)
class Limit:
    """Seconds that a door may take, given what it takes while nothing else goes on.

    `by_work`: also open where the web process works no more than `factor` times as long until the answer.
    """

    factor: float
    more: float
    most: float = CLOSED
    by_work: bool = False

    def of(self, idle: float) -> float:
        return min(self.factor * idle + self.more, self.most)


#: What the issue asks for, on a machine that does nothing else.
PAGE, VERDICT = Limit(2.0, 0.0, 0.5), Limit(2.0, 1.0)
#: On a machine that does other things, these take the processors from either measurement, and a page of ten
#: milliseconds may take twice as long for a moment of theirs: a tenth of a second more is nobody's flood, and neither
#: is a page for which the web process has worked twice as much at most, for it and for all whom it served before.
PAGE_BESIDE_OTHERS = Limit(2.0, 0.1, by_work=True)


class Bystander:
    """A member of a class with a browser; each door is a method that returns seconds."""

    def __init__(self, service: Service) -> None:
        self._service, self._count = service, 0
        self._browser = httpx.Client(
            base_url=service.addresses[0], headers={"Cookie": service.student.cookie}, timeout=CLOSED
        )
        self._bearer = {"Authorization": f"Bearer {service.student.token}"}
        self._known_browser = httpx.Client(base_url=service.addresses[0], timeout=CLOSED)
        self.login()
        self._stream = BoardStream(service)

    def close(self) -> None:
        self._stream.close()
        for client in (self._browser, self._known_browser):
            client.close()

    def page(self) -> float:
        """The mean of three: the lessons of a module, an exercise, and one's classes."""
        began = time.perf_counter()
        for path in PAGES:
            self._get(path)
        return (time.perf_counter() - began) / len(PAGES)

    def verdict(self) -> float:
        began = time.perf_counter()
        self._submit(self._new_code())
        return time.perf_counter() - began

    def cell(self) -> float:
        return self._post(f"/{MODULE}/cellules", {"code": "2 + 2"})

    def steps(self) -> float:
        return self._post(f"/{MODULE}/cellules/pas", {"code": "a = 2\nb = a + 2\n"})

    def board(self) -> float:
        """From a verdict to what the teacher's board shows of it."""
        self._stream.wait_until_quiet()
        submitted = time.perf_counter()
        seen = self._stream.events
        self._submit(self._new_code())
        return self._stream.wait_for_more(seen) - submitted

    def figure(self) -> float:
        address = self._submit(f"{self._new_code()}\ncomposer = lambda a, b: a + {self._count}\n")
        page = self._get(address).text
        path = page.partition(f'"{address}/figures/')[2].partition('"')[0].replace("&amp;", "&")
        assert path, page
        began = time.perf_counter()
        self._get(f"{address}/figures/{path}")
        return time.perf_counter() - began

    def login(self) -> float:
        """From a browser in which one has logged in before."""
        began = time.perf_counter()
        answer = self._known_browser.post("/connexion", data={"login": LOGIN, "password": PASSWORD})
        assert answer.status_code == 303, answer.text
        return time.perf_counter() - began

    def _new_code(self) -> str:
        self._count += 1
        return f"{self._service.solution}\n# {self._count} {time.time()}\n"

    def _submit(self, code: str) -> str:
        """Send a program, and wait for its verdict; return the address of the attempt."""
        body = {"exercise": EXERCISE, "code": code}
        answer = self._browser.post("/api/v1/submissions", json=body, headers=self._bearer)
        assert answer.status_code == 202, answer.text
        self._browser.get(f"{answer.json()['url']}/events", headers=self._bearer)  # ends with the verdict
        return f"/soumissions/{answer.json()['id']}"

    def _get(self, path: str) -> httpx.Response:
        answer = self._browser.get(path)
        assert answer.status_code == 200, (path, answer.status_code)
        return answer

    def _post(self, path: str, body: object) -> float:
        began = time.perf_counter()
        answer = self._browser.post(path, json=body)
        assert answer.status_code == 200, (path, answer.status_code, answer.text)
        return time.perf_counter() - began


class BoardStream:
    """A teacher's stream of the class, read by a thread."""

    def __init__(self, service: Service) -> None:
        self.events, self._last = 0, 0.0
        self._changed = threading.Condition()
        self._client = httpx.Client(base_url=service.addresses[0], timeout=httpx.Timeout(CLOSED, read=None))
        self._request = self._client.build_request(
            "GET", f"/classes/{service.class_id}/evenements", headers={"Cookie": service.teacher.cookie}
        )
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._closed = False
        self._thread.start()

    def _read(self) -> None:
        while not self._closed:
            try:
                answer = self._client.send(self._request, stream=True)
                for line in answer.iter_lines():
                    if line.startswith("data:"):
                        with self._changed:
                            self.events, self._last = self.events + 1, time.perf_counter()
                            self._changed.notify_all()
            except httpx.HTTPError:
                time.sleep(0.05)

    def wait_until_quiet(self) -> None:
        """Return when nothing has come for a moment."""
        while time.perf_counter() - self._last < 0.3:
            time.sleep(0.02)

    def wait_for_more(self, seen: int) -> float:
        """Return when the event after so many came."""
        with self._changed:
            assert self._changed.wait_for(lambda: self.events > seen, CLOSED), "the board has shown nothing"
            return self._last

    def close(self) -> None:
        self._closed = True
        self._client.close()


@contextmanager
def flooding(service: Service, names: Sequence[str]) -> Iterator[dict[str, dict[str, int]]]:
    """Let floods go on; what they have done is there after the end."""
    given = json.dumps({"target": asdict(service.target), "floods": list(names)})
    command = [sys.executable, "-m", "tests.contract.gate.attacker", given]
    attacker = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    done: dict[str, dict[str, int]] = {}
    try:
        assert attacker.stdout
        attacker.stdout.readline()  # it has begun
        time.sleep(RUN_UP)
        yield done
        done |= json.loads(attacker.communicate("")[0])
    finally:
        attacker.kill()
        attacker.wait()


@dataclass
class Door:
    """Seconds that a door took."""

    limit: Limit
    #: Whether it waits for nothing but its own work; the board is told of at most so often, whatever it costs.
    tells_work: bool = True
    idle: list[float] = field(default_factory=list)
    flooded: list[float] = field(default_factory=list)
    #: Seconds of processor of the web process meanwhile: a place in its queue, whatever else the machine does.
    idle_work: list[float] = field(default_factory=list)
    flooded_work: list[float] = field(default_factory=list)

    @property
    def is_open(self) -> bool:
        if self.limit.by_work and median(self.flooded_work) <= self.limit.factor * median(self.idle_work):
            return True
        return median(self.flooded) <= self.limit.of(median(self.idle))

    def __str__(self) -> str:
        idle, flooded = 1000 * median(self.idle), 1000 * median(self.flooded)
        told = f"{idle:.0f} → {flooded:.0f} ms (×{flooded / idle:.1f}){'' if self.is_open else ' CLOSED'}"
        if not self.tells_work:
            return told
        work = 1000 * median(self.idle_work), 1000 * median(self.flooded_work)
        return f"{told} [{work[0]:.0f} → {work[1]:.0f} ms of processor, ×{work[1] / work[0]:.1f}]"


@dataclass
class Outcome:
    """What came of some floods, door by door."""

    floods: Sequence[str]
    doors: dict[str, Door]
    done: dict[str, dict[str, int]] = field(default_factory=dict)

    @property
    def closed(self) -> list[str]:
        return [f"{', '.join(self.floods)}: {name} {door}" for name, door in self.doors.items() if not door.is_open]

    def __str__(self) -> str:
        return f"{', '.join(self.floods)}: " + "; ".join(f"{name} {door}" for name, door in self.doors.items())


SAMPLES = {"page": 6, "login": 2, "board": 2}
Samples = dict[str, tuple[list[float], list[float]]]


def measure_idle(service: Service, bystander: Bystander, doors: Collection[str]) -> Samples:
    """Return seconds and work of doors while nothing else goes on."""
    samples: Samples = {name: ([], []) for name in sorted(doors)}
    service.clear()
    _sample(service, bystander, samples)
    return samples


def measure(
    service: Service,
    bystander: Bystander,
    names: Sequence[str],
    doors: Collection[str] | None = None,
    rounds: int = 3,
    page: Limit = PAGE,
    idle: Samples | None = None,
) -> Outcome:
    """Measure doors without and with floods, in turn, until all are open, or for so many rounds.

    Where all are open at once, nothing is measured again; `idle` is what was measured before.
    """
    chosen = sorted(doors or {door for name in names for door in FLOODS[name].doors})
    outcome = Outcome(names, {door: Door(page if door == "page" else VERDICT, door != "board") for door in chosen})
    for number in range(rounds):
        service.clear()
        if idle is not None and not number:
            for name, door in outcome.doors.items():
                door.idle, door.idle_work = list(idle[name][0]), list(idle[name][1])
        else:
            _sample(service, bystander, {name: (door.idle, door.idle_work) for name, door in outcome.doors.items()})
        with flooding(service, names) as done:
            _sample(
                service, bystander, {name: (door.flooded, door.flooded_work) for name, door in outcome.doors.items()}
            )
        outcome.done = done
        service.clear()
        if not outcome.closed:
            break
        _sample(service, bystander, {name: (door.idle, door.idle_work) for name, door in outcome.doors.items()})
        if not outcome.closed:
            break
    return outcome


def _sample(service: Service, bystander: Bystander, into: Samples) -> None:
    for name, (seconds, work) in into.items():
        measured: Callable[[], float] = getattr(bystander, name)
        for _ in range(SAMPLES.get(name, 3)):
            before = service.processor()
            seconds.append(measured())
            work.append(service.processor() - before)
