"""Coverage-guided fuzzing of the decoder and of the whole reading path with atheris (extra `fuzz`).

    python tests/fuzz/covered.py decode 1000000    # bytes given to the decoder
    python tests/fuzz/covered.py told 300000       # bytes of a fault, through to its message
    python tests/fuzz/covered.py session 300000    # bytes sent on the wire by a child, through a whole session

Prints libFuzzer's own account (inputs, coverage, memory). An input that breaks a property is left as ``crash-…``.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import atheris

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
with atheris.instrument_imports(include=["server.sandbox"]):
    import server.sandbox.child.decoder
    import server.sandbox.session  # noqa: F401

from tests.fuzz import reading

DICTIONARY = (
    *("N", "T", "F", "i", "I", "f", "c", "s", "a", "t", "l", "d"),
    *(r"\x01\x00\x00\x00", r"\x02\x00\x00\x00", r"\xff\xff\xff\xff", r"\x00\x00\x00\x80"),
    *("kind", "exception", "text", "line", "frames", "detail", "timeout", "syntax_error", "import_error"),
    *("invalid_output", "output_limit", "depth|[0]|f", "type|[1]|f", "' was never closed", "ModuleNotFoundError"),
)


def decode(data: bytes) -> None:
    reading.decode_soundly(data)


def told(data: bytes) -> None:
    reading.tell_soundly(data)


def session(data: bytes) -> None:
    """The first byte chooses the moment, the kind of frame and the way to die; the rest is what is sent."""
    if not data:
        return
    choice, rest = data[0], data[1:]
    kind = (19, 20, 18, 250)[choice >> 1 & 3]
    reading.converse_soundly(
        rest if choice & 0x80 else reading.framed(rest, kind),
        loading=bool(choice & 1),
        status=reading.status(choice >> 3),
    )


def seeds(folder: Path, prefix: bytes) -> None:
    for number, seed in enumerate(reading.SEEDS):
        (folder / str(number)).write_bytes(prefix + seed)


def main(target: str, runs: str) -> None:
    chosen: Callable[[bytes], None] = {"decode": decode, "told": told, "session": session}[target]
    with tempfile.TemporaryDirectory() as corpus:
        words = Path(corpus, "words")
        words.write_text("".join(f'"{word}"\n' for word in DICTIONARY), encoding="ascii")
        inputs = Path(corpus, "inputs")
        inputs.mkdir()
        seeds(inputs, b"\x02" if target == "session" else b"")
        options = [
            "-max_len=4096",
            "-len_control=10",
            "-rss_limit_mb=512",
            "-timeout=5",
            "-print_final_stats=1",
            f"-dict={words}",
        ]
        atheris.Setup([sys.argv[0], f"-runs={runs}", *options, str(inputs)], chosen)
        atheris.Fuzz()


if __name__ == "__main__":
    main(*sys.argv[1:])
