"""The words of a module's texts: which of them a word that is looked for stands for.

Words are compared without accents, capitals and ligatures; those of one stem (Snowball's French) count as one; a word
that stands nowhere is taken for the one that is spelt most like it.
"""

from __future__ import annotations

import difflib
import re
import string
import unicodedata
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable, Sequence
from threading import Lock

import numpy as np

from graders.typography import limit_marks, unaccented

WORD = re.compile(r"[^\W_]+")
SHORTEST_STEM, SHORTEST_TYPO = 4, 4
#: How much alike (`difflib`'s ratio) a word and what it is taken for are at least: « noued » and « noeud » are at 0.8.
ALIKE = 0.8
#: Words to compare letter by letter, those that share the most letters first.
MAX_COMPARED = 40
LETTERS = string.ascii_lowercase + string.digits


def normalise_spelling(text: str) -> str:
    """Small letters, accents composed: how words are kept."""
    return unicodedata.normalize("NFC", limit_marks(text)).lower()


class SearchVocabulary:
    """Built once over some texts, then only read; by several threads."""

    def __init__(self, texts: Iterable[str]) -> None:
        words = sorted({word for text in texts for word in WORD.findall(normalise_spelling(text))})
        import snowballstemmer

        self._stemmer, self._lock = snowballstemmer.stemmer("french"), Lock()
        self._spellings: dict[str, list[str]] = defaultdict(list)
        self._of_stem: dict[str, list[str]] = defaultdict(list)
        for word in words:
            self._spellings[unaccented(word) or word].append(word)
            self._of_stem[unaccented(self._stem_word(word))].append(word)
        self._plain = sorted(self._spellings)
        self._letters = np.ascontiguousarray(_count_letters_by_word(self._plain))
        self._lengths = np.array([len(word) for word in self._plain], dtype=np.int32)

    def _stem_word(self, word: str) -> str:
        """Return the stem. The stemmer holds the word that it works on: of two threads, one waits."""
        with self._lock:
            return str(self._stemmer.stemWord(word))

    def is_known_word(self, word: str) -> bool:
        """Whether it stands in the texts: it, its beginning, or another of its stem."""
        plain = unaccented(word) or word
        place = bisect_left(self._plain, plain)
        begins = place < len(self._plain) and self._plain[place].startswith(plain)
        return begins or any(stem in self._of_stem for stem in self.possible_stems(word))

    def possible_stems(self, word: str) -> set[str]:
        """Those of the words spelt so but for accents: « fermee » has the stem of « fermée »; failing that, its own."""
        spellings = self._spellings.get(unaccented(word)) or [word]
        return {unaccented(self._stem_word(spelling)) for spelling in spellings} - {""}

    def related_words(self, word: str) -> list[str]:
        """The words that one who looks for `word` means too, as they are spelt in the texts."""
        same = self._spellings.get(unaccented(word), [])
        return sorted(
            {
                *same,
                *(word_of_stem for stem in self.possible_stems(word) for word_of_stem in self._of_stem.get(stem, ())),
            }
        )

    def common_prefixes(self, word: str) -> list[str]:
        """What the words of its family begin with: « ferm » for « fermée », which finds « fermeture »."""
        return sorted(stem for stem in self.possible_stems(word) if len(stem) >= SHORTEST_STEM)

    def closest_known_word(self, word: str) -> str | None:
        """The word of the texts that is spelt most like one that stands nowhere; None where none is near."""
        plain = unaccented(word)
        if len(plain) < SHORTEST_TYPO:
            return None
        close = difflib.get_close_matches(plain, self._words_with_similar_letters(plain), n=1, cutoff=ALIKE)
        return self._spellings[close[0]][-1] if close else None  # the last one bears the accents

    def _words_with_similar_letters(self, normalised: str) -> list[str]:
        """The words that share enough letters to be alike, in whatever order: the bound of `difflib.quick_ratio`."""
        wanted = _count_letters_by_word([normalised])
        shared = np.minimum(self._letters, wanted).sum(axis=1, dtype=np.int32)
        alike = 2.0 * shared / (self._lengths + len(normalised))
        enough = np.flatnonzero(alike >= ALIKE)
        best = enough[np.argsort(-alike[enough], kind="stable")[:MAX_COMPARED]]
        return [self._plain[index] for index in best]


def _count_letters_by_word(words: Sequence[str]) -> np.ndarray:
    """Shape (words, 36): how often each letter or digit stands in each word, 255 times at most."""
    columns = [[min(word.count(letter), 255) for word in words] for letter in LETTERS]
    return np.array(columns, dtype=np.uint8).T
