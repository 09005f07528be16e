"""__MODULE__/__SLUG__ est un exercice déclaré : tout ce qui le corrige est dans `declaration.toml` et `solution.py`."""

from graders.core.declared.exercise import declared

DEFINITION = declared(__file__)
