"""What the students of a demonstration send looks as if students had written it."""

from __future__ import annotations

from server.demo.programs import format_as_student_file

SPECIMEN = b'''"""The author's words."""


def helper(x):
    return x


@staticmethod
def composer(a, b):
    """La somme."""
    return helper(a + b)


def composer(a, b):
    return a - b
'''


def test_each_function_stays_once_and_the_words_of_the_author_go() -> None:
    assert (
        format_as_student_file(SPECIMEN, 0)
        == b"def helper(x):\n    return x\n\n\ndef composer(a, b):\n    return a - b\n"
    )
    used = b"def f():\n    return 1\n\n\nold = f\n\n\ndef f():\n    return old()\n"
    assert format_as_student_file(used, 0) == used, "the first version is used"
    assert format_as_student_file(b"import math  # noqa: F401 (mistakes need it)\n", 0) == b"import math\n"


def test_a_program_that_is_sent_again_differs() -> None:
    again = [format_as_student_file(SPECIMEN, repeats).decode() for repeats in (1, 2)]
    assert [text.splitlines()[-2:] for text in again] == [
        ['    print("ici")', "    return a - b"],
        ['    print("ici 2")', "    return a - b"],
    ]
    assert format_as_student_file(b"f = lambda x: x", 1) == b'f = lambda x: x\nprint("ici")\n'
    assert format_as_student_file(b"def f(:\n", 1) == b'def f(:\n\nprint("ici")\n', "what cannot be read"
