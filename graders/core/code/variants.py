"""Many variants of one program in one process: a driver file that holds their texts, and calls their functions.

A launch costs more than most calls, so that a thousand changed programs are tried in a few launches. Each loop of a
variant counts its turns and stops at a bound: one that no longer ends costs nothing to those that follow.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, KitSettings, PlannedCalls, Programs, Reply, StudentFault
from graders.core.contract.values import Arguments

#: Turns of all loops of one call; characters of one driver file; deaths after which no driver is launched again.
MAX_TURNS, MAX_DRIVER, MAX_DEATHS = 20_000, 120_000, 8
CALL, LOOK = "appeler_une_variante", "regarder_une_variante"
#: The call by which a program has the variables of a place noted, and the function that notes values.
NOTE, SEE, SEEN = "_noter(locals())", "_voir", "voir_une_variante"
#: Values that one call notes, and numbers of one value.
MAX_SEEN = 200
_DRIVER = """
_textes, _modules, _de_base, _tours = {texts!r}, {{}}, dict(globals()), [0]
_suite = compile({suffix!r}, "solution.py", "exec")
_hasards = [(nom, nom.bit_generator.state) for nom in list(globals().values()) if hasattr(nom, "bit_generator")]

def _tour():
    _tours[0] += 1
    if _tours[0] > {turns}:
        raise TimeoutError

def {call}(numero, fonction, arguments, tirages=None):
    _tours[0] = 0
    try:
        if numero not in _modules:
            _modules[numero] = noms = dict(_de_base, _tour=_tour)
            exec(compile(_textes[numero], "solution.py", "exec"), noms)
            exec(_suite, noms)
        for hasard, etat in _hasards if tirages is not None else ():
            hasard.bit_generator.state = etat
            hasard.random(tirages)
        return _modules[numero][fonction](*arguments), ""
    except Exception as erreur:
        return None, type(erreur).__name__

def {look}(numero, fonction, arguments, demandes):
    notes = []
    _de_base["_noter"] = lambda noms: notes or notes.append(dict(noms))
    {call}(numero, fonction, arguments)
    noms = notes[0] if notes else {{}}
    return [[nom, float(noms[nom])] for nom in demandes if nom in noms and isinstance(noms[nom], (int, float))]
"""


_SEEING = """
_vues = []

def _aplatir(valeur):
    if hasattr(valeur, "ravel"):
        valeur = valeur.ravel().tolist()
    if isinstance(valeur, (list, tuple)):
        return [nombre for partie in valeur for nombre in _aplatir(partie)]
    return [float(valeur)]

def _voir(*valeurs):
    rendu = valeurs if len(valeurs) > 1 else valeurs[0]
    if len(_vues) < {seen}:
        try:
            nombres = _aplatir(rendu)
            if 0 < len(nombres) <= {seen}:
                _vues.append(nombres)
        except (TypeError, ValueError, RecursionError):
            pass
    return rendu

_de_base["_voir"] = _voir

def {look}(numero, fonction, arguments):
    _vues.clear()
    {call}(numero, fonction, arguments)
    return list(_vues)
"""


class VariantCaller:
    """Calls variants of a program, with the kit of a grading; `suffix` is executed behind each."""

    def __init__(self, programs: Programs, suffix: str = "") -> None:
        self._programs, self._deaths, self._suffix = programs, 0, suffix

    def call_variants(
        self, variants: Sequence[str], function: str, calls: Sequence[Arguments], kit: KitSettings,
        draws: Sequence[int] = (),
    ) -> list[list[Answer]]:  # fmt: skip
        """Return the answers of each variant to the calls; fewer where it died, or where too many have died.

        With `draws`, one for each call, the kit's generators begin each call where these numbers of draws leave them:
        all variants draw the same numbers.
        """
        answers: list[list[Answer]] = [[] for _ in variants]
        for begins, ends in _iter_driver_chunks(variants):
            begin = begins
            while begin < ends and self._deaths < MAX_DEATHS:
                begin += self._call_chunk(variants[begin:ends], answers, begin, function, calls, kit, draws)
        return answers

    def read_variables(
        self, text: str, function: str, arguments: Arguments, names: Sequence[str], kit: KitSettings
    ) -> list[tuple[str, float]]:
        """Return those of the variables that are numbers when a program first notes them (`NOTE`) in a call."""
        try:
            program = self._programs.open(_driver_source([text], self._suffix).encode(), kit)
        except StudentFault:
            return []
        try:
            noted = program.call(LOOK, 0, function, list(arguments), list(names)).value
        except StudentFault:
            return []
        finally:
            program.close()
        return [(name, value) for name, value in noted]

    def record_line_values(
        self, texts: Sequence[str], function: str, calls: Sequence[Arguments], kit: KitSettings
    ) -> list[list[Answer]]:
        """Return, for each text, the values that it notes in each call (`SEE`): rows of numbers, or a fault."""
        driver = _driver_source(texts, self._suffix) + _SEEING.format(seen=MAX_SEEN, look=SEEN, call=CALL)
        asked = [(k, function, list(call)) for k in range(len(texts)) for call in calls]
        try:
            program = self._programs.open(driver.encode(), kit)
        except StudentFault:
            return []
        try:
            answers = [a for _, block in program.call_batches([PlannedCalls(SEEN, asked)]) for a in block]
        finally:
            program.close()
        return [answers[k : k + len(calls)] for k in range(0, len(answers), len(calls))]

    def _call_chunk(
        self,
        variants: Sequence[str],
        answers: list[list[Answer]],
        begin: int,
        function: str,
        calls: Sequence[Arguments],
        kit: KitSettings,
        draws: Sequence[int],
    ) -> int:
        """Call variants in one process and return how many it is done with: up to one that kills it."""
        driver = _driver_source(variants, self._suffix)
        drawn: list[tuple[int, ...]] = [(count,) for count in draws] or [()] * len(calls)
        pairs = list(zip(calls, drawn, strict=True))
        asked = [(k, function, list(call), *count) for k in range(len(variants)) for call, count in pairs]
        count = 0
        try:
            program = self._programs.open(driver.encode(), kit)
        except StudentFault:
            self._deaths += 1
            return len(variants)
        try:
            for _, block in program.call_batches([PlannedCalls(CALL, asked)]):
                for answer in block:
                    answers[begin + count // len(calls)].append(_unpack_driver_answer(answer))
                    count += 1
        finally:
            program.close()
        if count < len(asked):
            self._deaths += 1
            return max(1, (count - 1) // len(calls) + 1)
        return len(variants)


def _iter_driver_chunks(variants: Sequence[str]) -> Iterator[tuple[int, int]]:
    """Yield ranges of variants whose texts fit into one driver."""
    begin, size = 0, 0
    for k, text in enumerate(variants):
        if size and size + len(text) > MAX_DRIVER:
            yield begin, k
            begin, size = k, 0
        size += len(repr(text))
    if begin < len(variants):
        yield begin, len(variants)


def _driver_source(variants: Sequence[str], suffix: str) -> str:
    return _DRIVER.format(texts=list(variants), suffix=suffix, turns=MAX_TURNS, call=CALL, look=LOOK)


def _unpack_driver_answer(answer: Answer) -> Answer:
    """Return the answer of a variant: its value, or the exception that the driver caught."""
    if isinstance(answer, StudentFault):
        return answer
    value, exception = answer.value
    return StudentFault(Outcome.RUNTIME_ERROR, "", exception=exception) if exception else Reply(value)
