"""The questions of an exercise answered without code, for the terminal."""

from graders.core.answers import Paper
from server.cli.report import number, paragraph

EXAMPLES = {"number": '"0,1"', "one": '"a"', "several": '["a", "b"]', "order": '["b", "a"]'}


def render(exercise: str, paper: Paper, seed: int) -> str:
    """The questions of a draw, their formulas in TeX."""
    lines = [f"{exercise}, graine {seed}", ""]
    lines += [f"  {one.symbol} = {one.text} {one.unit}".rstrip() + f"  ({one.name})" for one in paper.given]
    for one in paper.questions:
        unit = f" [{one.unit}]" if one.unit else ""
        lines += ["", f"{one.id}{unit} : {one.title} ({number(one.points)} points)", *paragraph(one.text, indent=2)]
        for piece in one.pieces:
            lines += list(paragraph(f"{piece.id}) {piece.text}", indent=4))
    return "\n".join([*lines, "", f"Réponses attendues en JSON : {{{_example(paper)}}}"])


def _example(paper: Paper) -> str:
    return ", ".join(f'"{one.id}": {EXAMPLES[one.form]}' for one in paper.questions)
