"""Full text of a module: lessons by section, glossary, exercises. Accents, capitals and endings do not count.

The index is an SQLite table in memory (FTS5), built at the first search with the vocabulary of its texts, which says
what else a word of a query stands for.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, product
from threading import Lock
from weakref import WeakKeyDictionary

from markupsafe import Markup, escape

from graders.typography import french
from server.course import Exercise, Module
from server.course.models import Lesson, Term
from server.reading.schemas import SearchHitView
from server.reading.vocabulary import WORD, SearchVocabulary, normalise_spelling
from server.sandbox.exceptions import USUAL_ERRORS

MAX_HITS = 30
MAX_QUERY_LENGTH, MAX_QUERY_WORDS = 200, 8  # the rest of a query is ignored
TITLE_WEIGHT, NAME_WEIGHT = 6.0, 20.0
WORDS_AROUND = 26
MAX_SMALL_WORDS = 3  # of a query of nothing but small words
MAX_PHRASE_WORDS = 60  # in all the combinations of word forms that are searched as phrases
#: How a numbered block begins, « Théorème 1 : », where others only speak of it.
NUMBERED = re.compile(r"\b[A-ZÉ]\w+\u00a0\d+(?= :)")
MARK_START, MARK_END = "\x02", "\x03"
#: Words that say nothing by themselves, and what an apostrophe leaves of them.
STOP_WORDS = {
    "a", "au", "aux", "avec", "ce", "ces", "d", "dans", "de", "des", "du", "elle", "en", "est", "et", "il", "j",
    "l", "la", "le", "les", "leur", "m", "n", "ne", "nous", "on", "ou", "par", "pas", "pour", "qu", "que",
    "qui", "quoi", "s", "sa", "se", "ses", "son", "sont", "sur", "t", "un", "une", "vous", "y",
}  # fmt: skip


@dataclass(frozen=True)
class SearchablePassage:
    """A place that can be found. `part` is its title, `label` and `title` say where it stands.

    `names` are other words by which one may look for it, which are not shown.
    """

    href: str
    label: str
    title: str
    part: str
    text: str
    names: str = ""


@dataclass(frozen=True)
class SearchResult:
    """What was found. `read_as` is the query as it was understood, where a word of it stands nowhere as typed."""

    hits: tuple[SearchHitView, ...] = ()
    read_as: str = ""


def search_lessons(module: Module, query: str) -> SearchResult:
    """The places that speak of all the words of `query`, first where they stand together; failing that, of some."""
    return load_index(module).find_passages(query)


_indexes: WeakKeyDictionary[Module, SearchIndex] = WeakKeyDictionary()


def is_index_prepared(module: Module) -> bool:
    return module in _indexes


def load_index(module: Module) -> SearchIndex:
    """Return the module's index; to make it takes about a second."""
    index = _indexes.get(module)
    if index is None:
        index = _indexes[module] = SearchIndex(tuple(_module_passages(module)))
    return index


class SearchIndex:
    """One table, behind a lock: the bounds above keep a search under some milliseconds, whatever the query."""

    def __init__(self, passages: Sequence[SearchablePassage]) -> None:
        self._passages = passages
        self._lock = Lock()
        self._vocabulary = SearchVocabulary(f"{passage.part} {passage.text} {passage.names}" for passage in passages)
        self._table = sqlite3.connect(":memory:", check_same_thread=False)
        options = "tokenize = 'unicode61 remove_diacritics 2', prefix = '2 3'"
        self._table.execute(f"CREATE VIRTUAL TABLE passages USING fts5(title, body, names, {options})")
        rows = (
            (number, passage.part, _remove_highlight_marks(passage.text), passage.names)
            for number, passage in enumerate(passages)
        )
        self._table.executemany("INSERT INTO passages(rowid, title, body, names) VALUES (?, ?, ?, ?)", rows)
        self._table.execute("INSERT INTO passages(passages) VALUES ('optimize')")

    def find_passages(self, query: str, max_hits: int = MAX_HITS) -> SearchResult:
        asked = split_query_words(query)
        if not asked:
            return SearchResult()
        mended = {word: self._corrected_spelling(word) for word in asked}
        hits = self._find_ranked_hits(
            [self._alternative_terms(word) for word in mended.values()], [*mended.values()], max_hits
        )
        changed = any(word != instead for word, instead in mended.items())
        return SearchResult(hits, " ".join(mended.values()) if changed and hits else "")

    def _corrected_spelling(self, word: str) -> str:
        return word if self._vocabulary.is_known_word(word) else self._vocabulary.closest_known_word(word) or word

    def _alternative_terms(self, word: str) -> list[str]:
        """Each word as FTS5 takes it; the first is meant as a beginning, and FTS5 does not take ligatures apart."""
        kin = self._vocabulary.related_words(word) if _has_inflected_forms(word) else []
        ligature = [_fts_prefix_term(word.replace("oe", "œ"))] if "oe" in word else []
        return [_fts_prefix_term(word), *ligature, *(f'"{spelling}"' for spelling in kin if spelling != word)]

    def _word_family_query(self, word: str, related_words: Sequence[str]) -> str:
        """Whatever begins as the words of its family do."""
        beginnings = self._vocabulary.common_prefixes(word) if _has_inflected_forms(word) else []
        return _join_terms_with_or([*related_words, *map(_fts_prefix_term, beginnings)])

    def _find_ranked_hits(
        self, related_words: list[list[str]], terms: list[str], max_hits: int
    ) -> tuple[SearchHitView, ...]:
        phrases = _join_terms_with_or(
            [" + ".join(phrase) for phrase in islice(product(*related_words), MAX_PHRASE_WORDS // len(related_words))]
        )
        every = " AND ".join(map(_join_terms_with_or, related_words))
        family = " AND ".join(
            self._word_family_query(word, alike) for word, alike in zip(terms, related_words, strict=True)
        )
        hits: dict[int, SearchHitView] = {}
        for match in dict.fromkeys((phrases, every, family)):
            if len(hits) >= max_hits:
                break  # what comes later only follows
            hits = hits | {
                place: hit for place, hit in self._run_match_query(match, max_hits).items() if place not in hits
            }
        return tuple(
            (hits or self._run_match_query(" OR ".join(map(_join_terms_with_or, related_words)), max_hits)).values()
        )[:max_hits]

    def _run_match_query(self, match: str, max_hits: int) -> dict[int, SearchHitView]:
        """Rank first, then quote the best: a quotation takes longer than all the rest."""
        rank = f"bm25(passages, {TITLE_WEIGHT}, 1.0, {NAME_WEIGHT}), rowid"
        best = f"SELECT rowid FROM passages WHERE passages MATCH ? ORDER BY {rank} LIMIT ?"
        quotation = f"snippet(passages, 1, '{MARK_START}', '{MARK_END}', '…', {WORDS_AROUND})"
        with self._lock:
            order = [number for (number,) in self._table.execute(best, (match, max_hits))]
            rows = f"passages MATCH ? AND rowid IN ({', '.join(map(str, order))})"
            quoted = dict(self._table.execute(f"SELECT rowid, {quotation} FROM passages WHERE {rows}", (match,)))
        return {number: _build_hit_view(self._passages[number], quoted[number]) for number in order}


def split_query_words(query: str) -> tuple[str, ...]:
    """The words to look for, each meant as a beginning. Small ones only count where there is no other."""
    all_words = list(dict.fromkeys(WORD.findall(normalise_spelling(query[:MAX_QUERY_LENGTH]))))
    telling = [word for word in all_words if word not in STOP_WORDS] or all_words[:MAX_SMALL_WORDS]
    return tuple(telling[:MAX_QUERY_WORDS])


def _has_inflected_forms(word: str) -> bool:
    """Numbers and letters are meant as they are: « théorème 1 » is not the tenth, « A* » is no adverb."""
    return not word.isdigit() and len(word) > 1


def _fts_prefix_term(word: str) -> str:
    return f'"{word}"*' if _has_inflected_forms(word) else f'"{word}"'


def _join_terms_with_or(terms: Sequence[str]) -> str:
    return f"({' OR '.join(dict.fromkeys(terms))})"


def _build_hit_view(passage: SearchablePassage, snippet: str) -> SearchHitView:
    marked = str(escape(snippet)).replace(MARK_START, "<mark>").replace(MARK_END, "</mark>")
    return SearchHitView(passage.href, passage.label, passage.title, passage.part, Markup(marked))


def _remove_highlight_marks(text: str) -> str:
    return text.replace(MARK_START, " ").replace(MARK_END, " ").replace("\0", " ")


def _module_passages(module: Module) -> Iterator[SearchablePassage]:
    for term in module.glossary.values():
        yield _term_passage(module, term)
    yield from _error_passages(module)
    for lesson in module.lessons:
        yield from _lesson_passages(lesson)
    for exercise in module.exercises:
        yield _exercise_passage(exercise)


def _term_passage(module: Module, term: Term) -> SearchablePassage:
    return SearchablePassage(f"/{module.slug}/glossaire#t-{term.id}", "Glossaire", "", term.word, term.text, term.id)


def _error_passages(module: Module) -> Iterator[SearchablePassage]:
    """Yield the names of Python's errors; they stand in the glossary."""
    for name, meaning in USUAL_ERRORS.items() if module.glossary else ():
        place = f"/{module.slug}/glossaire#e-{name.lower()}"
        yield SearchablePassage(place, "Glossaire", "Erreurs de Python", name, meaning, name)


def _lesson_passages(lesson: Lesson) -> Iterator[SearchablePassage]:
    href = f"/{lesson.module}/lire/{lesson.slug}"
    above = " ".join(section.text for section in lesson.sections if not section.id)
    if lesson.solution:  # what it tells is not given away here
        yield SearchablePassage(href, lesson.label, lesson.title, lesson.title, french(lesson.summary))
        return
    yield SearchablePassage(href, lesson.label, lesson.title, lesson.title, f"{french(lesson.summary)} {above}")
    for section in lesson.sections:
        if section.id:
            numbered = " ".join(NUMBERED.findall(section.text))
            place = f"{href}#{section.id}"
            yield SearchablePassage(place, lesson.label, lesson.title, section.title, section.text, numbered)


def _exercise_passage(exercise: Exercise) -> SearchablePassage:
    text = " ".join(f"{section.title} {section.text}" for section in exercise.statement.sections)
    href = f"/{exercise.module}/exercices/{exercise.slug}"
    return SearchablePassage(href, "Exercice", "", exercise.title, f"{french(exercise.summary)} {text}", exercise.slug)
