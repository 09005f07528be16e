"""TeX as a line of plain text, for the search: « θ ∈ ]−π, π] » rather than its source."""

from __future__ import annotations

import re
import unicodedata

SYMBOLS = {
    "times": "×", "cdot": "·", "le": "≤", "leq": "≤", "ge": "≥", "geq": "≥", "ne": "≠", "neq": "≠", "approx": "≈",
    "simeq": "≃", "equiv": "≡", "sim": "∼", "propto": "∝", "in": "∈", "notin": "∉", "subset": "⊂", "cup": "∪",
    "cap": "∩", "sum": "∑", "prod": "∏", "int": "∫", "infty": "∞", "partial": "∂", "nabla": "∇", "to": "→",
    "rightarrow": "→", "leftarrow": "←", "longrightarrow": "→", "mapsto": "↦", "Rightarrow": "⇒", "iff": "⇔",
    "Longleftrightarrow": "⇔", "oplus": "⊕", "ominus": "⊖", "otimes": "⊗", "pm": "±", "mp": "∓", "sqrt": "√",
    "mid": "|", "vert": "|", "lvert": "|", "rvert": "|", "lVert": "‖", "rVert": "‖", "Vert": "‖", "dots": "…",
    "ldots": "…", "cdots": "…", "vdots": "⋮", "ell": "ℓ", "top": "ᵀ", "circ": "°", "forall": "∀", "exists": "∃",
    "lfloor": "⌊", "rfloor": "⌋", "lceil": "⌈", "rceil": "⌉", "langle": "⟨", "rangle": "⟩", "varepsilon": "ε",
    "varphi": "φ", "vartheta": "θ", "degree": "°",
}  # fmt: skip
#: What lays out, and says nothing.
SILENT = {
    "mathbf", "mathrm", "mathsf", "mathit", "mathcal", "mathbb", "mathopen", "mathclose", "mathbin", "mathrel",
    "operatorname", "text", "textbf", "textit", "boldsymbol", "left", "right", "big", "Big", "bigg", "Bigg",
    "bigl", "bigr", "Bigl", "Bigr", "biggl", "biggr", "middle", "displaystyle", "limits", "nolimits",
    "overline", "underline", "hat", "widehat", "bar", "tilde", "vec", "dot", "ddot", "quad", "qquad", "begin",
    "end", "tfrac", "dfrac", "frac", "underbrace", "overbrace", "boxed", "hspace", "vspace", "phantom", "tag",
}  # fmt: skip
GROUP = r"\{((?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*)\}"
FRACTION = re.compile(rf"\\[td]?frac\s*{GROUP}\s*{GROUP}")
ENVIRONMENT = re.compile(r"\\(?:begin|end)\s*\{[^{}]*\}(?:\{[^{}]*\})?")
COMMAND = re.compile(r"\\([a-zA-Z]+)\*?")


def tex_as_plain_text(tex: str) -> str:
    """Lossy on purpose: letters, numbers and signs in their order, without what lays them out."""
    text = ENVIRONMENT.sub(" ", tex).replace("{,}", ",")
    while FRACTION.search(text):
        text = FRACTION.sub(r" \1/\2", text)
    text = COMMAND.sub(_replace_tex_command, text)
    text = re.sub(r"\\[\\,;:!> ]", " ", text)
    text = re.sub(r"[{}&$]|\\(?=[|{}%#_&])", "", text)
    return re.sub(r"(?<=[a-z]) \(", "(", re.sub(r"\s+", " ", text)).strip()


def _replace_tex_command(match: re.Match[str]) -> str:
    name = match[1]
    if name in SILENT:
        return " " if name in {"quad", "qquad"} else ""
    if name in SYMBOLS:
        return SYMBOLS[name]
    try:
        size = "CAPITAL" if name[0].isupper() else "SMALL"
        return unicodedata.lookup(f"GREEK {size} LETTER {'lamda' if name.lower() == 'lambda' else name}")
    except KeyError:
        return f" {name} "  # « ln p », « cos θ »
