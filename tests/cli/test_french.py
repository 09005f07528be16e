"""The command line never speaks English, whatever Python says it with and however it is misused."""

from __future__ import annotations

import argparse
import ast
import gettext
import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from itertools import chain
from operator import attrgetter
from typing import NamedTuple

import polib
import pytest

from server.cli import _build_parser, main
from server.cli.authors import KINDS
from server.cli.french import CATALOGUE, LOCALE
from tests.support.live import environment
from tests.support.quick import some

FOLDER = LOCALE / "fr" / "LC_MESSAGES"
# What only a programmer's mistake makes argparse say, until Python 3.13.
TO_PROGRAMMERS = {
    "%r is not callable",
    "'required' is an invalid argument for positionals",
    ".__call__() not defined",
    "cannot have multiple subparser arguments",
    "cannot merge actions - two groups are named %r",
    "conflicting subparser alias: %s",
    "conflicting subparser: %s",
    "dest= is required for options like %r",
    "invalid conflict_resolution value: %r",
    "invalid option string %(option)r: must start with a character %(prefix_chars)r",
    "mutually exclusive arguments must be optional",
}
# What Python 3.12, 3.13 and 3.14 say besides 3.11 (Lib/test/translationdata/argparse in CPython).
LATER = {
    " (default: %(default)s)",
    "%(heading)s:",
    "%(prog)s: warning: %(message)s\n",
    "argument '%(argument_name)s' is deprecated",
    "command '%(parser_name)s' is deprecated",
    "invalid choice: %(value)r, maybe you meant %(closest)r? (choose from %(choices)s)",
    "option '%(option)s' is deprecated",
    "show program's version number and exit",
    "subcommands",
}


class Message(NamedTuple):
    """The singular, and the plural where there is one, in both languages."""

    english: tuple[str, ...]
    french: tuple[str, ...]


def messages() -> list[Message]:
    return [
        Message((one.msgid, one.msgid_plural), tuple(one.msgstr_plural[number] for number in sorted(one.msgstr_plural)))
        if one.msgid_plural
        else Message((one.msgid,), (one.msgstr,))
        for one in polib.pofile(str(FOLDER / f"{CATALOGUE}.po"))
    ]


def said_by_argparse() -> set[str]:
    """The messages that it looks for a translation of, on this Python."""
    calls = (node for node in ast.walk(ast.parse(inspect.getsource(argparse))) if isinstance(node, ast.Call))
    looked_up = (call for call in calls if isinstance(call.func, ast.Name) and call.func.id in {"_", "ngettext"})
    return {
        arg.value
        for call in looked_up
        for arg in call.args
        if isinstance(arg, ast.Constant) and isinstance(arg.value, str)
    }


def test_all_that_argparse_may_say_to_a_user_has_its_french() -> None:
    french = {form for message in messages() for form in message.english}
    assert len(said_by_argparse()) > 20
    assert said_by_argparse() - TO_PROGRAMMERS <= french
    assert french >= LATER


def test_a_translation_says_what_the_message_says() -> None:
    for english, french in (pair for message in some(messages()) for pair in zip(*message, strict=True)):
        assert french.strip()
        holes, filled = ([*sorted(re.findall(r"%(?:\((\w+)\))?[rs]", text))] for text in (english, french))
        assert holes == filled, "a hole of the message is not in its translation"
        assert english.endswith("\n") is french.endswith("\n")


def test_the_compiled_catalogue_is_the_one_that_is_read() -> None:
    with (FOLDER / f"{CATALOGUE}.mo").open("rb") as file:
        compiled = gettext.GNUTranslations(file)
    for message in some(messages()):
        for count, french in zip((1, 2), message.french, strict=False):
            singular, *plural = message.english
            got = compiled.ngettext(singular, plural[0], count) if plural else compiled.gettext(singular)
            assert got == french, "compile it again: see the head of the .po"


def parsers() -> dict[str, argparse.ArgumentParser]:
    """Every command, and those inside it, by what one types."""
    return dict(_below("", _build_parser()))


def _below(name: str, parser: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for part, inner in action.choices.items():
                yield f"{name} {part}".strip(), inner
                yield from _below(f"{name} {part}".strip(), inner)


def misuses(command: list[str], parser: argparse.ArgumentParser) -> Iterator[list[str]]:
    """Ways of asking wrongly for a command, from what it takes."""
    positionals = [action for action in parser._actions if not action.option_strings]
    needed = ["x" for action in positionals if action.nargs is None]
    if any(action.required and action.nargs != "*" for action in parser._actions):
        yield command
    if any(isinstance(action, argparse._SubParsersAction) for action in positionals):
        yield [*command, "zut"]
        return
    if all(action.nargs != "*" for action in positionals):
        yield [*command, *("x" for _ in positionals), "--no-such", *["de trop"] * (len(positionals) + 1)]
    yield [*command, *needed, "--absent"]
    for action in parser._actions:
        for option in action.option_strings:
            if action.nargs == 0:
                if option.startswith("--"):
                    yield [*command, *needed, f"{option}=oui"]
            else:
                yield [*command, *needed, option]
                if action.type is not None and action.metavar != "DIR":
                    yield [*command, *needed, option, "deux"]


def all_misuses() -> list[list[str]]:
    """Of the command line itself, and of each parser in turn."""
    by_parser = (misuses(command.split(), parser) for command, parser in parsers().items())
    return [[], ["zut"], ["--absent"], ["serve", "--h"], *chain.from_iterable(by_parser)]


def words(text: str) -> set[str]:
    """Its words in small letters, but for names of options and for holes."""
    return set(re.findall(r"\b[a-z]{2,}\b", re.sub(r"--\w+|%\(\w+\)|%[rs]", " ", text)))


@cache
def english_words() -> set[str]:
    """The words of argparse that no French message has; the kind of a skeleton, which one types, is no word."""
    english, french = (
        {word for message in messages() for word in words(" ".join(forms(message)))}
        for forms in (attrgetter("english"), attrgetter("french"))
    )
    return english - french - {*KINDS}


def test_english_is_recognised() -> None:
    assert {
        "usage",
        "expected",
        "required",
        "following",
        "unrecognized",
        "invalid",
        "error",
        "the",
    } <= english_words()


def test_no_misuse_of_any_parser_is_answered_in_english(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.cli._build_parser", cache(_build_parser))  # a parser is the same after each use
    assert len(all_misuses()) > 150
    for misuse in all_misuses():
        with pytest.raises(SystemExit) as stopped:
            main(misuse)
        said = capsys.readouterr()
        assert (stopped.value.code, said.out) == (2, ""), misuse
        assert said.err.startswith("utilisation"), misuse
        typed = {word for argument in misuse for word in words(argument)}
        assert (words(said.err) & english_words()) - typed == set(), misuse


def test_no_help_is_in_english(capsys: pytest.CaptureFixture[str]) -> None:
    for command in some(["", *parsers()]):
        with pytest.raises(SystemExit):
            main([*command.split(), "--help"])
        assert words(capsys.readouterr().out) & english_words() == set(), command


@pytest.mark.parametrize("language", [{"LC_ALL": "C"}, {"LANGUAGE": "en:de", "LANG": "en_US.UTF-8"}, {"LANG": ""}])
def test_it_speaks_french_whatever_the_machine_speaks(language: dict[str, str]) -> None:
    command = [sys.executable, "-X", "utf8", "-m", "server", "serve", "--port"]
    done = subprocess.run(command, env={**environment(), **language}, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "il manque sa valeur" in done.stderr
