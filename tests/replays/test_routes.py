"""The address of a replay's data: what it answers, what it refuses, and that it stays within its bounds."""

from __future__ import annotations

import asyncio
import gzip
import json
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from starlette.requests import Request

from graders.scene.parameters import Values
from server.app import create_app
from server.base.errors import Invalid, NotFound, RateLimited
from server.base.settings import Settings
from server.replays.routes import MAX_WAITING, ReplayQueue
from server.replays.service import CompressedReplay, ReplayLibrary, ReplayScript
from tests.support.client import TestClient
from tests.support.quick import migrated, the_course

SCRIPT = """
from graders.scene.replay import *
TITLE, ALT = "L'essai", "Un point"
PARAMETERS = {"n": Slider("Nombre", 1, 9, 1, 3), "tirage": Draw()}
def compute(values, rng):
    points = rng.random((values.whole("n"), 2))
    return Replay(View(0, 0, 1, 1), [Frame([Points(points, "truth")])], ["Voilà : c'est tout !"])
"""


@pytest.fixture
def replays(tmp_path: Path) -> ReplayLibrary:
    folder = tmp_path / "m9" / "rejeux"
    folder.mkdir(parents=True)
    (folder / "un_essai.py").write_text(SCRIPT, encoding="utf-8")
    (folder / "_aide.py").write_text("", encoding="utf-8")
    return ReplayLibrary(tmp_path)


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    settings = Settings(data_dir=tmp_path_factory.mktemp("data"), workers=0)
    database = migrated(settings)
    with TestClient(create_app(settings, course=the_course())) as made:
        yield made
    database.close()


def read(answer: CompressedReplay) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(gzip.decompress(answer.compressed))
    return found


def test_a_new_file_is_a_new_replay(replays: ReplayLibrary) -> None:
    assert replays.replay_names("m9") == ("un-essai",)
    script = replays.find("m9", "un-essai")
    body = read(replays.compute(script, script.read([("n", "5")])))
    assert body["title"] == "L’essai"
    assert body["summary"] == ["Voilà\xa0: c’est tout\u202f!"]
    assert body["values"] == {"n": 5, "tirage": 0}
    assert [one["name"] for one in body["parameters"]] == ["n", "tirage"]


def test_the_same_settings_give_the_same_bytes_and_another_draw_gives_others(replays: ReplayLibrary) -> None:
    script = replays.find("m9", "un-essai")
    first, again = (replays.compute(script, script.read([])) for _ in range(2))
    other = replays.compute(script, script.read([("tirage", "1")]))
    assert first == again
    assert read(first)["frames"] != read(other)["frames"]


@pytest.mark.parametrize(("module", "name"), [("m9", "_aide"), ("m9", "autre"), ("m8", "un-essai"), ("..", "un-essai")])
def test_what_is_not_there_is_not_found(replays: ReplayLibrary, module: str, name: str) -> None:
    with pytest.raises(NotFound):
        replays.find(module, name)


@pytest.mark.parametrize(
    "query", [[("x", "1")], [("n", "3"), ("n", "4")], [("n", "0")], [("n", "1" * 100)], [("N", "3")], [("", "")]]
)
def test_a_query_that_asks_for_what_is_not_declared_is_refused(
    replays: ReplayLibrary, query: list[tuple[str, str]]
) -> None:
    with pytest.raises(Invalid):
        replays.find("m9", "un-essai").read(query)


def test_answers_are_remembered_up_to_so_many_bytes(replays: ReplayLibrary, tmp_path: Path) -> None:
    script = replays.find("m9", "un-essai")
    settings = [script.read([("tirage", str(k))]) for k in range(8)]
    size = len(replays.compute(script, settings[0]).compressed)
    small = ReplayLibrary(tmp_path, memory_bytes=4 * size)
    for values in settings:
        small.compute(script, values)
        small.compute(script, values)
    kept = [small.find_cached(script, values) is not None for values in settings]
    assert 2 <= sum(kept) <= 4
    assert kept[-1]
    assert not kept[0]


def test_an_answer_comes_compressed_or_not_and_is_not_sent_twice(client: TestClient) -> None:
    plain = client.get("/l20/rejeux/lidar", headers={"Accept-Encoding": "identity"})
    packed = client.get("/l20/rejeux/lidar", headers={"Accept-Encoding": "gzip"})
    assert plain.status_code == packed.status_code == 200
    assert "content-encoding" not in plain.headers
    assert packed.headers["content-encoding"] == "gzip"
    assert plain.json() == packed.json()
    again = client.get("/l20/rejeux/lidar", headers={"If-None-Match": plain.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


@pytest.mark.parametrize(
    "query",
    [
        "rayons=0", "rayons=181", "rayons=NaN", "rayons=1e2", "rayons=", "rayons=8&rayons=8", "inconnu=1",
        "pose=1,2", "pose=99,1,0", "pose=1,1,inf", "tirage=-1", "tirage=100", "bruit=" + "9" * 500,
        "bruit=" + quote("0,5"), "rayons=" + quote("٨"), "rayons=%00", "rayons=" + quote("8\n"), "%ff=1",
        "rayons[]=8", "pose=<script>",
    ],
)  # fmt: skip
def test_hostile_queries_get_a_problem_in_french(client: TestClient, query: str) -> None:
    answer = client.get(f"/l20/rejeux/lidar?{query}")
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"
    body = answer.json()
    assert body["title"] == "Données refusées"
    assert body["detail"].endswith(".")


@pytest.mark.parametrize(
    "address", ["/l20/rejeux/rien", "/l20/rejeux/_carte", "/l20/rejeux/-carte", "/m9/rejeux/lidar", "/l20/rejeux/LIDAR"]
)
def test_other_addresses_are_not_found(client: TestClient, address: str) -> None:
    answer = client.get(address)
    assert answer.status_code == 404
    assert answer.json()["detail"]


class Slow(ReplayLibrary):
    """Counts how many computations run at once; each waits for the test."""

    def __init__(self, curriculum: Path) -> None:
        super().__init__(curriculum)
        self.running, self.most, self.done, self.go = 0, 0, 0, threading.Event()

    def compute(self, script: ReplayScript, values: Values) -> CompressedReplay:
        self.running += 1
        self.most = max(self.most, self.running)
        assert self.go.wait(300)
        self.running -= 1
        self.done += 1
        return super().compute(script, values)


class Reader(Request):
    """A request whose sender may have gone."""

    def __init__(self, gone: bool = False) -> None:
        super().__init__({"type": "http"})
        self.gone = gone

    async def is_disconnected(self) -> bool:
        return self.gone


def test_one_computation_at_a_time_a_short_queue_and_none_for_who_has_left(
    replays: ReplayLibrary, tmp_path: Path
) -> None:
    slow = Slow(tmp_path)
    script = slow.find("m9", "un-essai")
    settings = [script.read([("tirage", str(k))]) for k in range(MAX_WAITING + 1)]

    async def crowd() -> list[CompressedReplay | BaseException | None]:
        desk = ReplayQueue(slow)
        readers = [Reader(gone=k % 2 == 1) for k in range(MAX_WAITING)]
        waiting = [
            asyncio.ensure_future(desk.answer(reader, script, values))
            for reader, values in zip(readers, settings, strict=False)
        ]
        while not slow.running:
            await asyncio.sleep(0.001)
        with pytest.raises(RateLimited):
            await desk.answer(Reader(), script, settings[-1])
        slow.go.set()
        answers = await asyncio.gather(*waiting)
        assert await desk.answer(Reader(), script, settings[-1]) is not None
        return list(answers)

    with ThreadPoolExecutor(1) as apart:  # another test of this process may have left a loop running in this thread
        answers = apart.submit(asyncio.run, crowd()).result()
    assert slow.most == 1
    assert slow.done == MAX_WAITING // 2 + 1
    assert [answer is None for answer in answers] == [k % 2 == 1 for k in range(MAX_WAITING)]
