"""Names of Python and of numpy that the editor proposes in every exercise, and the French line about each.

These of numpy are what any exercise needs, so that they hint at no solution; others are proposed where a statement
writes them, with the line that stands here if there is one.
"""

from __future__ import annotations

from collections.abc import Mapping

#: By name: what one writes after it, and a line. Names with a dot are those of a module.
BUILTINS: Mapping[str, tuple[str, str]] = {
    "abs": ("(x)", "la valeur absolue"),
    "all": ("(valeurs)", "vrai si toutes le sont"),
    "any": ("(valeurs)", "vrai si l’une au moins l’est"),
    "bool": ("(x)", "vrai ou faux"),
    "dict": ("(…)", "un dictionnaire"),
    "enumerate": ("(valeurs)", "les paires (indice, valeur)"),
    "float": ("(x)", "un nombre à virgule"),
    "int": ("(x)", "un entier ; la partie après la virgule est coupée"),
    "isinstance": ("(x, type)", "vrai si x est de ce type"),
    "len": ("(valeurs)", "combien il y en a"),
    "list": ("(valeurs)", "une liste"),
    "max": ("(valeurs)", "la plus grande"),
    "min": ("(valeurs)", "la plus petite"),
    "print": ("(…)", "affiche, sur une ligne"),
    "range": ("(début, fin, pas)", "les entiers de début à fin, fin exclue"),
    "reversed": ("(valeurs)", "les valeurs, de la dernière à la première"),
    "round": ("(x, chiffres)", "le nombre arrondi"),
    "set": ("(valeurs)", "un ensemble, sans doublon"),
    "sorted": ("(valeurs)", "une liste triée"),
    "str": ("(x)", "un texte"),
    "sum": ("(valeurs)", "la somme"),
    "tuple": ("(valeurs)", "un tuple"),
    "zip": ("(a, b)", "les paires d’éléments de même rang"),
}
NUMPY: Mapping[str, tuple[str, str]] = {
    "np.abs": ("(x)", "la valeur absolue, élément par élément"),
    "np.arange": ("(début, fin, pas)", "un tableau de valeurs espacées de pas, fin exclue"),
    "np.array": ("(valeurs)", "un tableau de ces valeurs"),
    "np.cos": ("(x)", "le cosinus, x en radians"),
    "np.exp": ("(x)", "l’exponentielle"),
    "np.linspace": ("(début, fin, n)", "n valeurs régulières, fin comprise"),
    "np.log": ("(x)", "le logarithme népérien"),
    "np.max": ("(a, axis)", "la plus grande valeur"),
    "np.min": ("(a, axis)", "la plus petite valeur"),
    "np.ones": ("(forme)", "un tableau de 1"),
    "np.pi": ("", "π"),
    "np.sin": ("(x)", "le sinus, x en radians"),
    "np.sqrt": ("(x)", "la racine carrée"),
    "np.sum": ("(a, axis)", "la somme"),
    "np.tan": ("(x)", "la tangente, x en radians"),
    "np.zeros": ("(forme)", "un tableau de 0"),
}
#: Lines about names that are proposed only where a statement writes them.
RARER: Mapping[str, tuple[str, str]] = {
    "np.arctan2": ("(y, x)", "l’angle du vecteur (x, y), dans [−π, π]"),
    "np.argmax": ("(a, axis)", "l’indice de la plus grande valeur"),
    "np.argmin": ("(a, axis)", "l’indice de la plus petite valeur"),
    "np.clip": ("(x, bas, haut)", "x, ramené entre bas et haut"),
    "np.column_stack": ("(colonnes)", "un tableau fait de ces colonnes"),
    "np.cumsum": ("(a)", "les sommes successives"),
    "np.diff": ("(a)", "les écarts entre valeurs voisines"),
    "np.eye": ("(n)", "la matrice identité"),
    "np.full": ("(forme, valeur)", "un tableau de cette valeur"),
    "np.inf": ("", "l’infini"),
    "np.linalg.inv": ("(A)", "l’inverse d’une matrice"),
    "np.linalg.norm": ("(v, axis)", "la norme"),
    "np.linalg.solve": ("(A, b)", "la solution x de A x = b"),
    "np.linalg.svd": ("(A)", "la décomposition en valeurs singulières : U, S, Vᵀ"),
    "np.mean": ("(a, axis)", "la moyenne"),
    "np.nan": ("", "« pas un nombre »"),
    "np.roll": ("(a, décalage, axis)", "les valeurs décalées, en rond"),
    "np.searchsorted": ("(a, v)", "où insérer v dans a trié"),
    "np.sort": ("(a)", "un tableau trié"),
    "np.std": ("(a, axis)", "l’écart-type"),
    "np.where": ("(condition, a, b)", "a là où c’est vrai, b ailleurs"),
}
