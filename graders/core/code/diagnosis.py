"""Diagnosis of a submission by re-enactment: the known mistake that gives the same outputs.

Each misconception of the exercise is run through the same checks with the same inputs. The one whose outputs coincide
with the submission's wherever either is wrong, and which explains more failures than any other, names the mistake.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType

from graders.core.code.folder import Misconception
from graders.core.code.recognised import NamingGround
from graders.core.code.reenacting import Reenactment
from graders.core.code.runner import Observation
from graders.core.compare.slips import SLIPS, Slip
from graders.core.contract.values import same_value
from graders.core.contract.verdict import AND_ALSO, LIKELY, CheckResult, Diagnosis
from graders.typography import elided

MIN_AGREEMENT = 0.9
#: First words of what is told beside the mistakes: the points that they cost, the checks that fail too.
EXPLAINS, FAILS_TOO = "Cela explique", "Autre vérification qui échoue"
OTHERS_FAIL = "Autres vérifications qui échouent"
#: Said of a mistake that shows only where the other functions are right.
_HIDDEN = "se voit avec les autres fonctions justes"
#: Begin of what is said of answers, by some explanations themselves.
_ANSWERS_ARE = "Vos réponses sont celles"
#: Said of a mistake that others resemble; of answers that are those of a mistake, or of several.
_RESEMBLES = "Votre fonction répond comme avec cette erreur ; d'autres donneraient cela aussi."
_ALIKE, _TOGETHER = "que donne cette erreur.", "que donnent ces erreurs."


@dataclass(frozen=True)
class Explanation:
    """How well a misconception explains a submission."""

    misconception: Misconception
    explained: int
    agreement: float

    @property
    def rank(self) -> tuple[int, float]:
        return (self.explained, self.agreement)


def choose_explanation(explanations: Sequence[Explanation]) -> Misconception | None:
    """Return the misconception that explains the failures better than any other, or None.

    Two mistakes that cannot be told apart on the graded inputs are not named: a wrong name is worse than none.
    """
    if not explanations:
        return None
    best, *others = sorted(explanations, key=lambda e: e.rank, reverse=True)
    rivals = [e for e in others if e.rank == best.rank and _are_rivals(e.misconception, best.misconception)]
    return None if rivals else best.misconception


def _are_rivals(misconception: Misconception, other: Misconception) -> bool:
    return misconception.id != other.id and bool(set(misconception.functions) & set(other.functions))


def explain_observations(
    observations: Sequence[Observation], misconception: Misconception, reenactment: Reenactment
) -> Explanation | None:
    """Return how well a misconception explains the observations; None where it does not."""
    seen = reenactment.observe(partial(is_ruled_out, observations, misconception))
    pairs = _pair_observations(observations, seen)
    relevant = [p for p in pairs if p[0].function in misconception.functions and not (p[0].ok and p[1].ok)]
    explained = sum(not mine.ok and are_same_results(mine, other) for mine, other in pairs)
    agreement = sum(are_same_results(*p) for p in relevant) / len(relevant) if relevant else 0.0
    if agreement < MIN_AGREEMENT or not any(not mine.ok and are_same_results(mine, other) for mine, other in relevant):
        return None
    return Explanation(misconception, explained, agreement)


def is_ruled_out(
    observations: Sequence[Observation], misconception: Misconception, seen: Sequence[Observation]
) -> bool:
    """Whether the checks re-enacted so far already rule the misconception out."""
    judged = [o for o in observations if o.function in misconception.functions]
    pairs = _pair_observations(judged, seen)
    differing = sum(not (mine.ok and other.ok) and not are_same_results(mine, other) for mine, other in pairs)
    return differing > (1.0 - MIN_AGREEMENT) * len(judged) + 1e-9


def have_same_wrong_results(
    observations: Sequence[Observation], seen: Sequence[Observation], function: str, tolerance: float
) -> bool:
    """Whether two programs gave the same results wherever one of them is wrong, nearly always, and one is."""
    pairs = _pair_observations([mine for mine in observations if mine.function == function], seen)
    telling = [(mine, other) for mine, other in pairs if not (mine.ok and other.ok)]
    alike = sum(
        mine.ok == other.ok and mine.fault == other.fault and same_value(mine.value, other.value, tolerance=tolerance)
        for mine, other in telling
    )
    return bool(telling) and alike >= MIN_AGREEMENT * len(telling)


def _pair_observations(
    mine: Sequence[Observation], seen: Sequence[Observation]
) -> list[tuple[Observation, Observation]]:
    """Return the pairs of observations of both programs at the same index of the same check and function."""
    theirs = {(o.check, o.index, o.function): o for o in seen}
    return [(o, theirs[o.check, o.index, o.function]) for o in mine if (o.check, o.index, o.function) in theirs]


def are_same_results(observation: Observation, other: Observation) -> bool:
    """Whether two observations have the same value, or the same fault."""
    if observation.fault or other.fault:
        return observation.fault == other.fault
    return observation.ok == other.ok and same_value(observation.value, other.value)


def combine_diagnoses(
    ids: Sequence[str],
    misconceptions: Sequence[Misconception],
    facts: Sequence[Slip] = (),
    *,
    hidden: Collection[str] = (),
    grounds: Mapping[str, NamingGround] = MappingProxyType({}),
    answering: Mapping[str, Collection[str]] = MappingProxyType({}),
    explains_all: bool = True,
) -> Diagnosis:
    """Return one diagnosis of several mistakes, slips and facts: the id of the first, the texts of all.

    `hidden` are the titles of those that show only where the other functions are right, `grounds` those of the ids,
    `answering` the functions that answer as with a mistake, by its id (none of one function alone).
    What is true only of a program with one mistake is left out beside another one, and where not `explains_all`.
    """
    named: dict[str, Misconception | Slip] = {**SLIPS, **{mistake.id: mistake for mistake in misconceptions}}
    together: list[Misconception | Slip] = [*(named[mistake] for mistake in ids), *facts]
    is_alone = len(together) == 1 and explains_all
    by_answers = [
        m.id for m in together if grounds.get(m.id) is NamingGround.ANSWERS and _ANSWERS_ARE not in m.explanation
    ]
    paragraphs: list[str] = []
    for mistake in together:
        explanation = mistake.explanation if is_alone else _explanation_true_beside_other_mistakes(mistake)
        ground = grounds.get(mistake.id)
        is_hidden, is_likely = mistake.title in hidden, ground is NamingGround.RESEMBLANCE
        begin = f"Cette erreur {_HIDDEN}. " if is_hidden else ""
        if paragraphs:
            other = f"Autre erreur{f', qui {_HIDDEN}' if is_hidden else ''}{', peut-être' if is_likely else ''}"
            begin = f"{other} : {lowercase_title(mistake.title)}. "
        if is_likely:
            begin += f"{_RESEMBLES} "
        elif mistake.id in by_answers[:1]:
            functions = sorted({function for name in by_answers for function in answering.get(name, ())})
            begin += f"{_answers_of(functions)} {_TOGETHER if len(by_answers) > 1 else _ALIKE} "
        paragraphs += [begin + explanation, mistake.question]
    titles = [
        f"{LIKELY}{lowercase_title(m.title)}" if grounds.get(m.id) is NamingGround.RESEMBLANCE else m.title
        for m in together
    ]
    titles[1:] = [f"{title[:1].lower()}{title[1:]}" if title.startswith(LIKELY) else title for title in titles[1:]]
    title = AND_ALSO.join(titles)
    return Diagnosis(together[0].id, title, "\n\n".join(part.strip() for part in paragraphs))


def _answers_of(functions: Sequence[str]) -> str:
    """Return the begin of a sentence on the answers of these functions, or of the only one."""
    names = " et ".join(elided("de", function) for function in functions)
    return f"Les réponses {names} sont celles" if functions else _ANSWERS_ARE


def _explanation_true_beside_other_mistakes(mistake: Misconception | Slip) -> str:
    """Return what a mistake's explanation says of every program that has the mistake, among others."""
    explanation = mistake.explanation
    for text in mistake.alone:
        before, after = (part.strip() for part in explanation.split(text, 1))
        word = re.split(r"\W", after, maxsplit=1)[0]
        is_new_sentence = not before or before.endswith((".", "!", "?"))
        if is_new_sentence and (len(word) > 1 or after[1:2] == "'") and "_" not in word:
            after = after[:1].upper() + after[1:]
        explanation = f"{before} {after}".strip() if after[:1] not in ".," else before + after
    return explanation


def add_unexplained_checks(
    diagnosis: Diagnosis,
    checks: Sequence[CheckResult],
    doubtful: Collection[str] = (),
    *,
    besides: Collection[str] = (),
    mended: Collection[str] = (),
    is_quoted: bool = False,
) -> Diagnosis:
    """Return the diagnosis with the other failed checks, if any, and with how many of the lost points it explains.

    The points are told where all of the checks that it explains have been `mended`: the program was run without the
    mistake, and passed them. Those `besides` are explained too; nothing is said of the `doubtful` ones, which may fail
    for the same reason, nor where the diagnosis explains no check in particular; the points of checks without a fault
    are not counted. If `is_quoted`, the first other check is told with its message.
    """
    explained = {check for ids in diagnosis.explains for check in ids}.union(besides)
    lost = [check for check in checks if not (check.passed or check.neutral)]
    left = [check for check in lost if check.id not in explained.union(doubtful)]
    if not left or explained.isdisjoint(check.id for check in lost):
        return diagnosis
    named = " ; ".join(f"« {check.title} »" for check in left)
    fail = OTHERS_FAIL if len(left) > 1 else FAILS_TOO
    if is_quoted and left[0].message and not left[0].repeats:
        named += f". {left[0].message.splitlines()[0].removesuffix('.')}"
    least = "au moins " if any(check.id in doubtful and check.id not in explained for check in lost) else ""
    share = (
        f"{least}{_lost_points_text(check for check in lost if check.id in explained)} des {_lost_points_text(lost)}"
    )
    counted = f"{EXPLAINS} {share} points perdus. " if explained and explained.issubset(mended) else ""
    told = f"{counted}{fail} : {named}."
    if waiting := [check for check in checks if check.neutral]:
        titles = " ; ".join(f"« {check.title} »" for check in waiting)
        told += f" Les autres points attendent que le reste soit juste : {titles}."
    return replace(diagnosis, explanation=f"{diagnosis.explanation}\n\n{told}")


def _lost_points_text(checks: Iterable[CheckResult]) -> str:
    return points_text(sum(check.max_points - check.points for check in checks))


def points_text(points: float) -> str:
    return f"{points:g}".replace(".", ",")


def lowercase_title(title: str) -> str:
    """Return a title for mid-sentence: first letter in lower case, unless in a symbol or name."""
    word = title.split(" ", 1)[0]
    return title[:1].lower() + title[1:] if word[1:].islower() or word in ("L'angle", "L'inverse") else title


def diagnose_slip(slips: Sequence[tuple[Sequence[str], str | None]]) -> Diagnosis | None:
    """Return the diagnosis of the slip seen in most of the failed checks, for when no misconception fits.

    `slips` holds the functions and the slip of each failed check, None where no slip explains it. Checks of several
    functions count only where those of one function show no slip.
    """
    alone = [slip for functions, slip in slips if len(functions) == 1]
    candidates = alone if any(alone) else [slip for _, slip in slips]
    counted = Counter(slip for slip in candidates if slip is not None)
    if not counted:
        return None
    (name, times), *others = counted.most_common(2)
    if 2 * times <= len(candidates) or (others and others[0][1] == times):
        return None
    return combine_diagnoses([name], ())
