"""The questions of an exercise answered without code, for the terminal."""

from graders.core.answers import Paper
from server.cli.report import wrap_paragraph
from server.client.program.report import format_number

EXAMPLES = {"number": '"0,1"', "one": '"a"', "several": '["a", "b"]', "order": '["b", "a"]'}
FORMS = {"one": "Une seule réponse est bonne.", "several": "Une ou plusieurs réponses sont bonnes."}


def render_questions(exercise: str, paper: Paper, seed: int) -> str:
    """The questions of a deal, their formulas in TeX."""
    lines = [f"{exercise}, graine {seed}", ""]
    lines += [f"  {datum.symbol} = {datum.text} {datum.unit}".rstrip() + f"  ({datum.name})" for datum in paper.given]
    for question in paper.questions:
        unit = f" [{question.unit}]" if question.unit else ""
        lines += [
            "",
            f"{question.id}{unit} : {question.title} ({format_number(question.points)} points)",
            *wrap_paragraph(question.text, indent=2),
        ]
        if question.form in FORMS:
            lines += list(wrap_paragraph(FORMS[question.form], indent=2))
        for piece in question.pieces:
            lines += list(wrap_paragraph(f"{piece.id}) {piece.text}", indent=4))
    return "\n".join([*lines, "", f"Réponses attendues en JSON : {{{_answers_example(paper)}}}"])


def _answers_example(paper: Paper) -> str:
    return ", ".join(f'"{question.id}": {EXAMPLES[question.form]}' for question in paper.questions)
