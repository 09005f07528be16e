"""The authors' pages: made from the code, with commands that work and keys that exist."""

from __future__ import annotations

import ast
import dataclasses
import json
import re
import shlex
import tomllib
from pathlib import Path
from typing import Annotated, Any

import pytest
from pydantic import TypeAdapter

from server.authoring import schema, shapes
from server.authoring.keys import KEYS
from server.authoring.tables import FIELD_MEANINGS, PAGES, replace_tables_in_page
from server.cli import _build_parser, main
from server.course import Course
from tests.support.quick import the_course

TEXTS = {path.name: path.read_text(encoding="utf-8") for path in sorted(PAGES.glob("*.md"))}
WRAPPERS = {
    "ChoiceFile", "NumericFile", "MisconceptionsFile", "MistakesFile", "EquivalentsFile", "GlossaryFile",
    "FamiliesFile",
}  # fmt: skip


def blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("page", TEXTS)
def test_tables_are_those_of_the_code(page: str) -> None:
    assert replace_tables_in_page(TEXTS[page]) == TEXTS[page], "python -m server.authoring.tables"


def test_every_key_is_told_once_and_no_other() -> None:
    for model, keys in KEYS.items():
        assert list(keys) == list(model.model_fields), model
    for kind, fields in FIELD_MEANINGS.items():
        inherited = {name for base in kind.__mro__[1:] for name in getattr(base, "__dataclass_fields__", {})}
        assert set(fields) == {one.name for one in dataclasses.fields(kind)} - inherited, kind
    tables = re.findall(r"<!-- table: (\w+) -->", "".join(TEXTS.values()))
    told = {one.__name__ for one in (*KEYS, *FIELD_MEANINGS)} - WRAPPERS - {"PolicyEntry"}
    assert sorted(tables) == sorted(told | {"Comparateurs", "Simplificateurs", "Limites", "Issues", "Pages"})


@pytest.mark.parametrize("model", KEYS, ids=lambda model: model.__name__)
def test_each_example_is_one(model: Any) -> None:
    for name, key in KEYS[model].items():
        field = model.model_fields[name]
        TypeAdapter(Annotated[field.annotation, field]).validate_json(json.dumps(key.example_value))


def test_the_commands_of_the_first_hour_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    lines = [line for block in blocks(TEXTS["README.md"], "sh") for line in block.splitlines()]
    for line in lines:
        program, *arguments = shlex.split(re.sub(r"^BALISE_\w+=\S+ ", "", line))
        assert program == "balise"
        if arguments[0] in {"new", "schema"}:
            assert main(arguments) == 0, line
        else:
            _build_parser().parse_args(arguments)
    assert {line.split()[1] for line in lines if line.startswith("balise")} >= {"new", "preview", "check", "study"}
    assert (tmp_path / "commande" / "graders" / "l21" / "gain" / "solution.py").is_file(), "the paths that are written"
    rules = tomllib.loads((tmp_path / "commande" / schema.TAPLO).read_text(encoding="utf-8"))["rule"]
    assert all((tmp_path / "commande" / rule["schema"]["path"]).is_file() for rule in rules)
    for rule in rules:
        for pattern in rule["include"]:
            found = [*(tmp_path / "commande").glob(pattern.removeprefix("**/"))]
            assert found or "glossaire" in pattern or "equivalents" in pattern or "families" in pattern


@pytest.mark.parametrize("page", TEXTS)
def test_links_lead_somewhere_and_samples_are_python(page: str) -> None:
    prose = re.sub(r"`[^`]*`", "", TEXTS[page])
    for link in re.findall(r"\]\(([^)#]+)\)", prose):
        assert (PAGES / link).resolve().exists(), link
    for sample in blocks(TEXTS[page], "python"):
        ast.parse(sample)


def test_schemas_are_of_the_models_and_speak_french(course: Course) -> None:
    made = {shape.name: schema.build_json_schema(shape) for shape in shapes.SHAPES}
    assert made["exercise"]["properties"]["title"]["description"] == "titre de l’exercice"
    assert made["exercise"]["$defs"]["FunctionEntry"]["additionalProperties"] is False
    assert set(made["questions"]["discriminator"]["mapping"]) == {"choice", "order", "numeric"}
    for table in (one for whole in made.values() for one in (whole, *whole.get("$defs", {}).values())):
        for name, value in table.get("properties", {}).items():
            assert value.get("description"), name


def test_what_is_written_has_these_shapes(course: Course, place: Path) -> None:
    assert [*shapes.find_catalogue_faults(the_course())] == []
    assert [*shapes.find_catalogue_faults(course)] == []
    for shape in shapes.SHAPES:
        models = shape.model if isinstance(shape.model, tuple) else (shape.model,)
        assert all(model in KEYS for model in models)


def test_a_key_that_nothing_reads_is_told_with_its_line(course: Course, place: Path) -> None:
    path = place / "graders" / "l21" / "gain" / "misconceptions.toml"
    good = path.read_text(encoding="utf-8")
    path.write_text(good + 'edit = [["a", "b"]]\n', encoding="utf-8")
    try:
        (problem,) = shapes.find_catalogue_faults(course)
    finally:
        path.write_text(good, encoding="utf-8")
    assert (problem.path, problem.line) == (path, len(good.splitlines()) + 1)
    assert "edit" in problem.message
