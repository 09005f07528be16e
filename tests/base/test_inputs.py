"""Whatever routes take of strangers is read by registered readers, whose time a test of contracts measures."""

from __future__ import annotations

import ast
import re
import typing
from collections.abc import Iterable, Iterator
from datetime import date, datetime
from enum import Enum
from typing import Annotated, Any
from uuid import UUID

from annotated_types import MaxLen
from fastapi import APIRouter, FastAPI, Form, Header, UploadFile
from fastapi.dependencies.models import Dependant
from fastapi.routing import iter_route_contexts
from pydantic import BaseModel

from server.base.files import ROOT
from server.base.validation import TruncateTo
from tests.support.readers import READERS
from tests.support.service import Site

#: Where no request is read: what a person types in a shell, and what runs behind the walls.
ASIDE = {"authoring", "cli", "frontend", "sandbox"}
READS = {"body", "stream", "form", "json", "headers", "cookies", "query_params", "path_params", "url"}
REQUESTS, FORMS = {"request", "connection"}, {"FormData", "FormFields", "UploadFile"}
SCOPE = {"headers", "query_string", "path", "raw_path"}
#: Names that stand in the text of each file in which a request is read.
MAY_READ = re.compile(rf"\b(?:{'|'.join(sorted(REQUESTS | FORMS | {'scope', 'Headers'}))})\b")
MAX_BOUND = 2000  # characters of a parameter of an address, or of a header
PLAIN = (bool, int, float, UUID, datetime, date, type(None))


def flat(dependant: Dependant) -> Iterator[Dependant]:
    yield dependant
    for each in dependant.dependencies:
        yield from flat(each)


def texts_of(annotation: Any, name: str) -> Iterator[str]:
    """The texts in a type, by their names; nothing of numbers, UUIDs, moments and choices, which pydantic reads."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        for field, info in annotation.model_fields.items():
            yield from texts_of(info.annotation, f"{annotation.__name__}.{field}")
    elif is_read_by_pydantic(annotation):
        return
    elif typing.get_origin(annotation) is Annotated:
        yield from texts_of(typing.get_args(annotation)[0], name)
    elif typing.get_args(annotation) and typing.get_origin(annotation) is not dict:
        for argument in typing.get_args(annotation):
            yield from texts_of(argument, name)
    else:
        yield name


def is_read_by_pydantic(annotation: Any) -> bool:
    is_choice = typing.get_origin(annotation) is typing.Literal
    return is_choice or annotation in PLAIN or (isinstance(annotation, type) and issubclass(annotation, Enum))


def inputs_of(app: FastAPI) -> tuple[set[str], set[str]]:
    """Return the texts that routes take, and those parameters of addresses and headers that have no bound."""
    inputs, unbounded = set(), set()
    for route in iter_route_contexts(app.routes):
        for dependant in flat(getattr(route, "dependant", None) or Dependant()):
            for kind in ("path", "query", "header", "cookie", "body"):
                for parameter in getattr(dependant, f"{kind}_params"):
                    info = parameter.field_info
                    texts = set(texts_of(info.annotation, parameter.alias))
                    inputs |= {f"{type(info).__name__.lower()}:{text}" for text in texts}
                    if kind in ("query", "header", "cookie") and texts and not is_bounded(info.metadata):
                        unbounded.add(f"{kind}:{parameter.alias}")
    return inputs, unbounded


def is_bounded(metadata: Iterable[Any]) -> bool:
    return any(isinstance(each, MaxLen | TruncateTo) and each.max_length <= MAX_BOUND for each in metadata)


def raw_readers(tree: ast.AST, name: str, forms: frozenset[str] = frozenset()) -> Iterator[str]:
    """The functions that read of a request, of a form or of an ASGI scope what no parameter tells."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if node.value.id in forms or (node.value.id in REQUESTS and node.attr in READS):
                yield name
        elif isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and node.value.id == "scope":
            if isinstance(node.ctx, ast.Load) and getattr(node.slice, "value", "") in SCOPE:
                yield name
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Headers":
            yield name
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            every = (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)
            own = {each.arg for each in every if FORMS & names_in(each.annotation)}
            yield from raw_readers(node, f"{name}.{node.name}", forms | own)
        else:
            yield from raw_readers(node, f"{name}.{node.name}" if isinstance(node, ast.ClassDef) else name, forms)


def names_in(annotation: ast.AST | None) -> set[str]:
    return {node.id for node in ast.walk(annotation) if isinstance(node, ast.Name)} if annotation else set()


def test_what_routes_take_is_read_by_registered_readers_and_by_no_other(site: Site) -> None:
    inputs, unbounded = inputs_of(site.app)
    assert not unbounded, "a text of an address or of a header has a `max_length`, or is `TruncateTo` one"
    for path in sorted((ROOT / "server").rglob("*.py")):
        if not ASIDE & set(path.parts) and MAY_READ.search(source := path.read_text(encoding="utf-8")):
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            inputs |= {f"raw:{name}" for name in raw_readers(ast.parse(source), module)}
    registered = {name for reader in READERS for name in reader.inputs.split()}
    assert inputs - registered == set(), "register what reads it in tests/support/readers.py"
    assert registered - inputs == set(), "no route takes it any more"


class NewThing(BaseModel):
    text: str = ""
    table: dict[str, Any] = {}
    count: int = 0


def test_a_new_input_is_found() -> None:
    app, router = FastAPI(), APIRouter()

    @router.post("/{thing}")
    async def take(
        thing: str, body: NewThing, sought: str = "", bounded: Annotated[str, Header(max_length=9)] = ""
    ) -> None: ...

    @router.put("/x")
    async def put(file: UploadFile, typed: Annotated[str, Form()], many: Annotated[list[str], Form()]) -> None: ...

    app.include_router(router)
    assert inputs_of(app) == (
        {
            *("path:thing", "query:sought", "header:bounded", "body:NewThing.text", "body:NewThing.table"),
            *("file:file", "form:typed", "form:many"),
        },
        {"query:sought"},
    )
    source = """
class Door:
    async def read(self, request):
        return await request.body()
async def stream(request):
    def parts():
        return request.stream()
def pick(fields: Annotated[FormData, 1]):
    return fields["a"], fields.get("b")
async def app(scope, receive, send):
    return scope["query_string"]
def harmless(request):
    return request.app
"""
    assert set(raw_readers(ast.parse(source), "new")) == {"new.Door.read", "new.stream.parts", "new.pick", "new.app"}
