"""A program: which of some codes look alike, from standard input to standard output, as JSON.

Codes are read as sequences of tokens without names, comments and layout, and compared by fingerprints (winnowing:
Schleimer, Wilkerson and Aiken, SIGMOD 2003). What stands in the course too is left out of every code. What students
send may be made to take long: this process has bounds of its own, and ends by itself beyond them.
"""

from __future__ import annotations

import io
import json
import resource
import sys
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

MAX_CODES = 250
MAX_MEMORY_BYTES = 1024 * 1024 * 1024  # of addresses, what the libraries take to begin with among them
CPU_SECONDS = 40
GRAM_LENGTH = 25  # characters of a code without names: what is shorter is never found
WINDOW = 1
#: Own characters of the model: below, codes written apart look alike (15 of 893 pairs did with 349, of two hands that
#: had never met; none with 754 but those of one hand).
MIN_MODEL_LENGTH = 400
MIN_CODE_LENGTH = 200  # own characters of a code
MIN_SHARE = 0.75  # of both codes' own characters
MAX_PAIRS = 50


@dataclass(frozen=True)
class MatchingPair:
    """Two codes by their places, which part of each one's own characters the other has, and the lines, from 1."""

    first: int
    second: int
    shares: tuple[float, float]
    lines: tuple[tuple[int, ...], tuple[int, ...]]


def limit_resources() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY_BYTES, MAX_MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))


def fingerprint_code(code: str, known: Collection[int] = ()) -> Any:
    """Of what is in the code and not among the `known` grams.

    The library's own removal of known grams supposes that none comes twice in a code: here it is done by name.
    """
    from copydetect import CodeFingerprint
    from copydetect.utils import get_token_coverage

    found = CodeFingerprint("solution.py", GRAM_LENGTH, WINDOW, fp=io.StringIO(code), language="python")
    for gram in found.hashes.intersection(known):
        del found.hash_idx[gram]
    found.hashes.difference_update(known)
    found.token_coverage = get_token_coverage(found.hash_idx, GRAM_LENGTH, len(found.filtered_code))
    return found


def collect_gram_hashes(codes: Sequence[str]) -> frozenset[int]:
    return frozenset(gram for code in codes for gram in fingerprint_code(code).hashes)


def own_code_length(code: str, known: Collection[int]) -> int:
    """Characters of a code, without names and layout, that the course does not have."""
    return int(fingerprint_code(code, known).token_coverage)


def find_matching_pairs(codes: Sequence[str], course: Sequence[str]) -> Iterator[MatchingPair]:
    """The pairs of codes of which each has most of what the other has of its own, in their order."""
    from copydetect import compare_files

    known = collect_gram_hashes(course)
    prints = [fingerprint_code(code, known) for code in codes]
    for first, second in combinations(range(len(codes)), 2):
        left, other = prints[first], prints[second]
        if min(left.token_coverage, other.token_coverage) < MIN_CODE_LENGTH:
            continue
        _, shares, slices = compare_files(left, other)
        if min(shares) >= MIN_SHARE:
            lines = (_lines_of_slices(left.raw_code, slices[0]), _lines_of_slices(other.raw_code, slices[1]))
            yield MatchingPair(first, second, (float(shares[0]), float(shares[1])), lines)


def _lines_of_slices(code: str, slices: Any) -> tuple[int, ...]:
    """The lines, from 1, in which something of these slices of characters stands."""
    found: set[int] = set()
    for start, end in zip(*slices, strict=True):
        first, last = code.count("\n", 0, int(start)), code.count("\n", 0, max(int(start), int(end) - 1))
        found.update(range(first + 1, last + 2))
    return tuple(sorted(found))


def compare_codes_of_request(question: dict[str, Any]) -> dict[str, Any]:
    """`course`: what everyone has; `model`: how the exercise may be answered; `known`: other answers of the course;
    `codes`: what students sent.

    `too_short`: too little of the model is its own for codes to be compared.
    """
    length = own_code_length(question["model"], collect_gram_hashes(question["course"]))
    if length < MIN_MODEL_LENGTH:
        return {"too_short": True, "pairs": []}
    course = [*question["course"], question["model"], *question["known"]]
    pairs = sorted(find_matching_pairs(question["codes"], course), key=lambda pair: -sum(pair.shares))
    told = [[pair.first, pair.second, *pair.shares, *pair.lines] for pair in pairs[:MAX_PAIRS]]
    return {"too_short": False, "pairs": told}


if __name__ == "__main__":
    limit_resources()
    json.dump(compare_codes_of_request(json.load(sys.stdin)), sys.stdout)
