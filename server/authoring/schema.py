"""JSON Schemas of the TOML files that an author writes: editors complete keys by them, and tell what is wrong."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Union

from pydantic import BaseModel, Field, TypeAdapter

from server.authoring.keys import KEYS, DocumentedKey
from server.authoring.shapes import SHAPES, FileShape

DRAFT = "https://json-schema.org/draft/2020-12/schema"
FOLDER = ".schemas"
#: What Taplo, and the editors that use it, read.
TAPLO = ".taplo.toml"
KEYS_BY_MODEL_NAME = {model.__name__: keys for model, keys in KEYS.items()}


def write_schemas(place: Path) -> list[Path]:
    """Writes the schemas into the folder of a course, and which files they are of, where nothing says it yet."""
    folder = place / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    files = {
        folder / f"{shape.name}.json": json.dumps(build_json_schema(shape), ensure_ascii=False, indent=1)
        for shape in SHAPES
    }
    if not (place / TAPLO).exists():
        files[place / TAPLO] = _taplo_config()
    for path, text in files.items():
        path.write_text(text.rstrip() + "\n", encoding="utf-8")
    return list(files)


def _taplo_config() -> str:
    lines = ["# Quel schéma vaut pour quel fichier : « balise schema » les écrit."]
    for shape in SHAPES:
        if shape.path_patterns:
            include = json.dumps([f"**/{place}" for place in shape.path_patterns])
            lines += ["", "[[rule]]", f"include = {include}", "[rule.schema]"]
            lines += [f'path = "{os.path.join(".", FOLDER, shape.name)}.json"']
    return "\n".join(lines)


def build_json_schema(shape: FileShape) -> dict[str, Any]:
    """Its JSON Schema, with what each key means."""
    models = shape.model if isinstance(shape.model, tuple) else (shape.model,)
    made: dict[str, Any] = TypeAdapter(
        models[0] if len(models) == 1 else _union_discriminated_by_form(models)
    ).json_schema()
    for name, table in [(made.get("title", ""), made), *made.get("$defs", {}).items()]:
        _describe_properties(table, KEYS_BY_MODEL_NAME.get(name, {}))
    return {"$schema": DRAFT, **made, "title": shape.name}


def _union_discriminated_by_form(models: tuple[type[BaseModel], ...]) -> Any:
    """By their form."""
    return Annotated[Union[models], Field(discriminator="form")]  # noqa: UP007


def _describe_properties(table: dict[str, Any], keys: Mapping[str, DocumentedKey]) -> None:
    """In French, and without what a machine has made of the names."""
    table.pop("description", None)
    for name, value in table.get("properties", {}).items():
        value.pop("title", None)
        if name in keys:
            value["description"] = keys[name].meaning
            value["examples"] = [keys[name].example_value]
