"""Whether the extra `federation` is installed, without loading it."""

from functools import cache
from importlib.util import find_spec

MISSING = (
    "Ce serveur n’a pas de quoi entrer par le système d’un établissement : l’administrateur installe "
    "« balise[federation] », puis le redémarre."
)


@cache
def is_installed() -> bool:
    return all(find_spec(name) is not None for name in ("joserfc", "httpcore"))
