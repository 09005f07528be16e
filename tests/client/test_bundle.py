"""The client of one file: what it holds, and how it lays values out."""

from __future__ import annotations

import ast
import io
import sys
import zipfile
from typing import Any

import pytest

from server.base.version import VERSION
from server.client.bundle import MAX_BYTES, build_client_archive
from server.client.program import commands, report
from server.client.program.values import format_assignment
from tests.support.service import Site


def test_the_service_hands_out_a_client_of_its_own_version_and_address(site: Site) -> None:
    answer = site.client.get("/client/balise.pyz")
    assert answer.status_code == 200
    assert "balise.pyz" in answer.headers["Content-Disposition"]
    assert answer.content == build_client_archive("http://testserver")
    assert answer.content.startswith(b"#!/usr/bin/env python3\n")
    assert len(answer.content) <= MAX_BYTES
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        release = archive.read("balise/release.py").decode()
    assert "SERVER = 'http://testserver'" in release
    assert f"VERSION = {VERSION!r}" in release


def test_it_imports_the_standard_library_alone() -> None:
    with zipfile.ZipFile(io.BytesIO(build_client_archive("http://x"))) as archive:
        trees = [ast.parse(archive.read(name)) for name in archive.namelist()]
    nodes = [node for tree in trees for node in ast.walk(tree)]
    imported = {name.name for node in nodes if isinstance(node, ast.Import) for name in node.names}
    imported |= {node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module and not node.level}
    assert {name.split(".")[0] for name in imported} <= sys.stdlib_module_names | {"balise"}


def test_two_builds_have_the_same_bytes() -> None:
    first = build_client_archive("http://a")
    build_client_archive.cache_clear()
    assert build_client_archive("http://a") == first
    assert build_client_archive("http://b") != first


@pytest.mark.parametrize(
    ("value", "lines"),
    [
        (3, ["x = 3"]),
        (0.1, ["x = 0.1"]),
        ("inf", ["x = inf"]),
        ([], ["x = []"]),
        ([1.0, 2.5], ["x = [1, 2.5]"]),
        ([[1, 20], [300, 4]], ["x = [[  1, 20]", "     [300,  4]]"]),
        ([[1], [2, 3]], ["x = [[1], [2, 3]]"]),
        (["a", None, True], ["x = ['a', None, True]"]),
        ({}, ["x = {}"]),
        ({"(0, 1)": 0.5}, ["x = (0, 1): 0.5"]),
    ],
)
def test_values_are_laid_out_as_they_are(value: Any, lines: list[str]) -> None:
    assert format_assignment(value, "x") == lines


def test_long_values_are_cut_and_say_so() -> None:
    (line,) = format_assignment(list(range(1000)), "x")
    assert "1000 valeurs" in line
    assert "988 lignes de plus" in format_assignment([[0, 1]] * 1000, "x")[-1]


def test_control_characters_of_a_program_do_not_reach_the_terminal() -> None:
    verdict = {"outcome": "ok", "exercise": "a/b", "points": 20, "max_points": 20, "checks": [], "stdout": "\x1b[2Jx"}
    assert "\x1b" not in report.render_verdict({"verdict": verdict}, "http://x")


@pytest.mark.parametrize("arguments", [[], ["-h"], ["submit"], ["submit", "-h"], ["frobnicate"]])
def test_its_help_is_in_french(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        commands.main(arguments)
    captured = capsys.readouterr()
    help_text = captured.out + captured.err
    assert help_text.count("utilisation :") == 1
    assert not [word for word in ("usage", "positional", "required", "invalid", "show ") if word in help_text]
