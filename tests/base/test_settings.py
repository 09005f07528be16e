"""Settings: what is documented is what there is, and what is none is refused in French, with what was meant."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from server.base.files import ROOT
from server.base.settings import Settings, misspelt_variables, variable_name
from server.cli import CommandError, configuration, main
from server.cli.configuration import read_settings
from tests.support.quick import some

DOCUMENT = ROOT / "server" / "base" / "README.md"
NOT_OURS = {"PATH", "PYTHONPATH"}


def settings_table() -> Iterator[tuple[str, str, str]]:
    """Yield the name, default and meaning of each setting, as they are documented."""
    for name, field in Settings.model_fields.items():
        extra = field.json_schema_extra
        default = extra["told"] if isinstance(extra, dict) else f"{field.default:g}"
        yield variable_name(name), str(default), field.description or ""


def test_the_table_of_the_settings_is_theirs() -> None:
    rows = [f"| `{name}` | {default} | {meaning} |" for name, default, meaning in settings_table()]
    written = [line for line in DOCUMENT.read_text(encoding="utf-8").splitlines() if "BALISE_" in line and "|" in line]
    assert written[: len(rows)] == rows, "write these rows into the table:\n" + "\n".join(rows)
    assert len(rows) == len(Settings.model_fields)


def test_every_setting_says_what_it_is_and_what_it_is_without_being_set() -> None:
    for name, default, meaning in some(settings_table()):
        assert default not in {"", "None"}, name
        assert len(meaning) > 20, name


def variables_read(tree: ast.AST) -> Iterator[str]:
    """The names that a program looks for in its environment."""
    for node in ast.walk(tree):
        match node:
            case (
                ast.Call(
                    func=ast.Attribute(value=ast.Attribute(attr="environ"), attr="get"),
                    args=[ast.Constant(value=str(name)), *_],
                )
                | ast.Subscript(
                    value=ast.Attribute(attr="environ"), slice=ast.Constant(value=str(name)), ctx=ast.Load()
                )
                | ast.Call(func=ast.Attribute(attr="getenv"), args=[ast.Constant(value=str(name)), *_])
            ):
                yield name


def test_every_variable_that_anything_reads_is_documented() -> None:
    paths = [path for room in ("reference", "graders", "server", "tests") for path in (ROOT / room).rglob("*.py")]
    texts = (path.read_bytes() for path in paths if not {"hostile", "specimens", "node_modules"} & {*path.parts})
    trees = (ast.parse(text) for text in texts if b"environ" in text or b"getenv" in text)
    read = {name for tree in trees for name in variables_read(tree)}
    assert read >= {"XDG_DATA_HOME", "BALISE_DATA", "TEST_DATABASE_URL"}
    documented = set(re.findall(r"`\$?([A-Z_]+)", DOCUMENT.read_text(encoding="utf-8")))
    assert read - NOT_OURS <= documented


def refusal(**values: object) -> str:
    with pytest.raises(CommandError) as refused:
        read_settings(**values)
    return str(refused.value)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("BALISE_WORKRES", "BALISE_WORKERS"),
        ("balise_worker", "BALISE_WORKERS"),
        ("BALISE_DATA", "BALISE_DATA_DIR"),
        ("BALISE_DATABASE", "BALISE_DATABASE_URL"),
        ("BALISE_POLLSECONDS", "BALISE_POLL_SECONDS"),
    ],
)
def test_a_misspelt_setting_is_refused_with_the_one_that_was_meant(
    name: str, meant: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(name, "3")
    assert refusal() == f"réglages refusés :\n  {name} : ce réglage n’existe pas ; vouliez-vous dire {meant} ?"


def test_a_name_that_is_like_none_is_refused_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BALISE_QQ", "3")
    assert refusal() == "réglages refusés :\n  BALISE_QQ : ce réglage n’existe pas"


def test_right_names_in_any_case_and_others_variables_are_no_mistake() -> None:
    names = [variable_name(name) for name in Settings.model_fields]
    assert (
        list(misspelt_variables([*names, *(name.lower() for name in names), "BALISES", "PATH", "MY_BALISE_WORKRES"]))
        == []
    )


def test_settings_that_are_announced_are_no_mistake() -> None:
    assert list(misspelt_variables(["BALISE_COURSES", "BALISE_NATS_URL"])) == []
    assert list(misspelt_variables(["BALISE_COURSE"])) != []


REFUSED = {
    ("BALISE_WORKERS", "beaucoup"): "un nombre entier est attendu",
    ("BALISE_WORKERS", "2.5"): "un nombre entier est attendu",
    ("BALISE_WORKERS", "-1"): "il faut au moins 0",
    ("BALISE_WORKERS", "257"): "il faut au plus 256",
    ("BALISE_LEASE_SECONDS", "0"): "il faut plus de 0",
    ("BALISE_LEASE_SECONDS", "1,5"): "un nombre est attendu",
    ("BALISE_POLL_SECONDS", "inf"): "un nombre fini est attendu",
    ("BALISE_CODE_BYTES", "0"): "il faut au moins 1",
    ("BALISE_DATABASE_URL", ""): "ne peut être vide",
    ("BALISE_ROOT_PATH", "balise"): "« balise » n’est pas un chemin, comme « /balise »",
    **{
        ("BALISE_TIME_ZONE", name): f"« {name} » n’est pas un fuseau horaire, comme « Europe/Paris »"
        for name in ("Europe/Pari", "", "Europe", "../../etc/passwd", "/etc/localtime", "é" * 300)
    },
}


@pytest.mark.parametrize(("setting", "reason"), REFUSED.items(), ids=str)
def test_a_bad_value_is_refused_in_french(
    setting: tuple[str, str], reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    name, value = setting
    monkeypatch.setenv(name, value)
    assert refusal() == f"réglages refusés :\n  {name} : {reason} (valeur donnée : « {value} »)"


def test_all_that_is_wrong_is_told_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BALISE_WORKRES", "3")
    monkeypatch.setenv("BALISE_WORKERS", "x")
    monkeypatch.setenv("BALISE_SESSION_DAYS", "0")
    assert refusal().count("\n") == 3


@pytest.mark.parametrize("command", [["serve", "--port", "0"], ["worker"]])
def test_no_command_starts_with_a_misspelt_setting(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("BALISE_DATA_DIR", str(tmp_path / "data"))
    monkeypatch.setenv("BALISE_WORKRES", "3")
    assert main(command) == 2
    assert "BALISE_WORKERS" in capsys.readouterr().err
    assert not (tmp_path / "data").exists()


def test_postgresql_without_its_driver_is_refused_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BALISE_DATABASE_URL", "postgresql://u:secret@h/d")
    monkeypatch.setattr(configuration, "find_spec", lambda name: None)
    assert "pip install 'balise[postgresql]'" in refusal()
    assert "secret" not in refusal()


def test_a_secret_may_stand_in_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "balise_metrics_token").write_text("un jeton\n")
    (tmp_path / "balise_workers").write_text("3\n")
    (tmp_path / "postgres_password").write_text("d’un autre programme\n")
    monkeypatch.setenv("BALISE_SECRETS_DIR", str(tmp_path))
    monkeypatch.setenv("BALISE_WORKERS", "5")
    settings = read_settings()
    assert (settings.metrics_token, settings.workers) == ("un jeton", 5), "the environment counts first"
    assert "un jeton" not in repr(settings)


def test_a_folder_of_secrets_that_is_not_there_or_holds_a_misspelt_one_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BALISE_SECRETS_DIR", str(tmp_path / "rien"))
    assert "ne se lit pas : No such file" in refusal()
    monkeypatch.setenv("BALISE_SECRETS_DIR", str(tmp_path))
    (tmp_path / "balise_metrics_tokn").write_text("x")
    assert "vouliez-vous dire BALISE_METRICS_TOKEN ?" in refusal()
    (tmp_path / "balise_metrics_tokn").unlink()
    (tmp_path / "balise_workers").write_text("beaucoup")
    assert "BALISE_WORKERS : un nombre entier est attendu" in refusal()
