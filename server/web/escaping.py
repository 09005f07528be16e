"""What templates write is escaped as Jinja2 does it, but a page does so hundreds of times: what is markup already is
left as it is, and of plain text no markup is made that would only be joined."""

from __future__ import annotations

from html import escape as plain
from typing import Any

from jinja2 import Environment
from jinja2.compiler import CodeGenerator, Frame
from jinja2.nodes import Expr
from markupsafe import Markup, escape


def escaped(value: Any) -> str:
    kind = type(value)
    if kind is Markup:
        return str.__str__(value)
    if kind is int:
        return str(value)
    return plain(value) if kind is str else escape(value)


class _Writer(CodeGenerator):
    def _output_child_pre(self, node: Expr, frame: Frame, finalize: CodeGenerator._FinalizeInfo) -> None:
        if frame.eval_ctx.volatile or not frame.eval_ctx.autoescape or finalize.src is not None:
            super()._output_child_pre(node, frame, finalize)
        else:
            self.write("environment.escaped(")


class Pages(Environment):
    code_generator_class = _Writer
    escaped = staticmethod(escaped)
