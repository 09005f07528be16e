"""Proofs for `balise check`: each hunt has an answer of the announced size, and calls no right program wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from io import StringIO

from graders.core.code.hunts import CodeExercise, HuntPrograms, filter_showing_inputs, find_witness, list_hunts
from graders.core.code.wrong_lines import find_wrong_lines
from graders.core.contract.local import LOCAL

#: Seeds of the forms in which a hunt is checked.
CHECKED_FORMS = (0, 1, 2)
#: A line of the catalogue, and what is wrong with it, in French.
HuntFault = tuple[int, str]


def find_hunt_faults(exercise: CodeExercise, public: Sequence[str], right: Mapping[str, str]) -> Iterator[HuntFault]:
    """Yield what is wrong with an exercise's hunts, each with its line in the catalogue, in French.

    Each program, in several forms, must show its mistake on an input of the announced size, on which no program that
    is `right` (by its name) is called wrong, nor the program once its wrong lines are mended. Runs the course's
    programs in this process; what they print is left out.
    """
    with redirect_stdout(StringIO()):
        yield from list(_iter_hunt_faults(exercise, public, right))


def _iter_hunt_faults(exercise: CodeExercise, public: Sequence[str], right: Mapping[str, str]) -> Iterator[HuntFault]:
    ground = HuntPrograms(exercise, LOCAL)
    rights = {name: ground.open(source) for name, source in right.items()}
    for hunt in list_hunts(exercise):
        witness = find_witness(hunt, ground, ground.open(hunt.source))
        if witness is None:
            continue
        line, name = hunt.misconception.line, f"« {hunt.misconception.id} », dans {hunt.function}"
        for seed in CHECKED_FORMS:
            if not filter_showing_inputs(hunt, ground, ground.open(hunt.wrong_program_source(seed, public)), [witness]):
                yield (
                    line,
                    f"chasse de {name} : sous la forme {seed}, rien ne montre plus l’erreur sur {witness}",
                )
        changed = find_wrong_lines(exercise, hunt, CHECKED_FORMS[0], public)
        mended = "" if changed is None else changed.mend(hunt.wrong_program_source(CHECKED_FORMS[0], public))
        if mended and filter_showing_inputs(hunt, ground, ground.open(mended), [witness]):
            yield line, f"chasse de {name} : ses lignes fausses une fois corrigées, {witness} montre encore l’erreur"
        for file, program in rights.items():
            if filter_showing_inputs(hunt, ground, program, [witness]):
                yield line, f"chasse de {name} : {file}, qui est juste, passerait pour faux sur {witness}"
