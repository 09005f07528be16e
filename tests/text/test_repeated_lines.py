"""Runs of one line are folded; whatever a program may have been made to print stays."""

from hypothesis import given
from hypothesis import strategies as st

from server.text.repeated_lines import fold_repeated_lines


def test_a_log_that_repeats_itself_is_folded() -> None:
    log = "".join(f"[INFO] [{1000 + k / 10:.9f}] [frein]: stop, obstacle a 0.20 m\n" for k in range(113))
    first = log.split("\n")[0]
    assert fold_repeated_lines(log) == f"{first}\n… la même ligne, 112 fois encore\n"


def test_numbers_other_than_timestamps_are_left() -> None:
    text = "\n".join(f"tour {k}" for k in range(50))
    assert fold_repeated_lines(text) == text


def test_blank_lines_and_short_runs_are_left() -> None:
    text = "a\na\na\n\n\n\n\n\nb"
    assert fold_repeated_lines(text) == text


@given(st.lists(st.sampled_from(["x", "y", "[1.5] x", "[2.5] x", ""]), max_size=40))
def test_no_line_is_lost(lines: list[str]) -> None:
    """What is counted and what is shown add up to the lines there were."""
    folded = fold_repeated_lines("\n".join(lines)).split("\n")
    counted = sum(int(line.split(", ")[1].split()[0]) if line.startswith("… ") else 1 for line in folded)
    assert counted == max(len(lines), 1)
