"""Shapes of arrays that do not fit, indices outside of them, axes that they do not have, matrices without inverse."""

from __future__ import annotations

import re

from server.sandbox.explanations.patterns import OR_NONE, Pattern, plural, told
from server.sandbox.explanations.types import capitalise, describe_type


def shape(written: str) -> str:
    """Return a shape as Python writes it, from numpy's « (2,newaxis) »."""
    sizes = [size.strip().replace("newaxis", "1") for size in written.strip("() ").split(",") if size.strip()]
    return f"({sizes[0]},)" if len(sizes) == 1 else f"({', '.join(sizes)})"


def _operand_shapes(text: str) -> str:
    """Return the shapes of operands, of which numpy writes the result's last: it is told once."""
    found = list(dict.fromkeys(shape(it) for it in re.findall(r"\([\d,\s]*\)", text)))
    return " et ".join(found)


def _explain_index(match: re.Match[str], source: str) -> str:
    every = list(re.finditer(r"(\w+)\s*\[([^\[\]]+)\]", source))
    doubtful = [it for it in every if not re.fullmatch(r"[-\d,:\s]*", it[2])] or every
    if len({it[2] for it in doubtful}) > 1:
        places = ", ".join(dict.fromkeys(it[0] for it in doubtful))
        return f"Un indice doit être un nombre entier : lequel ne l’est pas, dans {places} ? Mettez-le dans int(…)."
    indexed = doubtful[0] if doubtful else None
    pieces = re.split(r"[,:\s]+", indexed[2]) if indexed else []
    text = next((it for it in pieces if it[:1] in "'\""), None)
    if indexed and text:
        return f"Un tableau se lit avec des indices entiers, et {text} est une chaîne de caractères ({indexed[0]})."
    where = f" ({indexed[0]})" if indexed else ""
    name = next((it for it in pieces if it.isidentifier()), None)
    number = next((it for it in pieces if re.fullmatch(r"-?\d*\.\d*", it)), None)
    if name is None and number:
        return f"Un indice doit être un nombre entier{where} : {number} est un nombre à virgule."
    return f"Un indice doit être un nombre entier{where} : int({name or 'x'}) ?"


def _explain_list_index(match: re.Match[str], source: str) -> str:
    if match[2] == "tuple":
        return f"{capitalise(describe_type(match[1]))} n’a qu’un indice : écrivez l[i][j], ou prenez un tableau numpy."
    if match[2] in ("float", "numpy.float64"):
        return _explain_index(match, source)
    return f"Un indice doit être un nombre entier, et c’est {describe_type(match[2])}."


def _explain_indexed_scalar(match: re.Match[str], source: str) -> str:
    return (
        "Cette valeur est un seul nombre : elle n’a pas d’indice. Y a-t-il une paire de crochets de trop, ou un "
        "tableau "
        "de moins de dimensions que prévu ?"
    )


def _explain_matmul(match: re.Match[str], source: str) -> str:
    right, left = match.groups()
    return (
        f"Produit matriciel de dimensions impossibles : à gauche {plural(left, 'colonne')}, à droite "
        f"{plural(right, 'ligne')} ; il en faut autant."
    )


def _explain_solve(match: re.Match[str], source: str) -> str:
    right, left = match.groups()
    return (
        f"Le système n’a pas le bon second membre : la matrice a {plural(left, 'ligne')}, et il a "
        f"{plural(right, 'ligne')} ; il en faut autant."
    )


def _explain_dot(match: re.Match[str], source: str) -> str:
    left, right, columns, rows = match.groups()
    return (
        f"Produit impossible entre les formes {shape(left)} et {shape(right)} : {columns} à gauche, {rows} à droite "
        "au lieu d’autant."
    )


def _explain_remapped(match: re.Match[str], source: str) -> str:
    originals = " et ".join(shape(it) for it in re.findall(r"(\([\d,\s]*\))->", match[1])) or _operand_shapes(match[1])
    return f"Ces tableaux n’ont pas des formes qui vont ensemble : {originals}."


def _explain_axis(match: re.Match[str], source: str) -> str:
    axis, dimensions = match.groups()
    if dimensions == "0":
        return f"L’axe {axis} n’existe pas : cette valeur est un seul nombre, sans axe."
    last = f", l’axe {int(dimensions) - 1}" if dimensions != "1" else ""
    return f"L’axe {axis} n’existe pas : ce tableau a {plural(dimensions, 'dimension')} (l’axe 0{last})."


def _explain_ends(match: re.Match[str], source: str) -> str:
    along, first, second = match.groups()
    return (
        "Les tableaux mis bout à bout doivent avoir les mêmes dimensions, sauf celle où ils se suivent : selon l’axe "
        f"{along}, l’un a {plural(first, 'élément')} et un autre {second}."
    )


#: Texts of numpy and scipy about shapes, indices and axes, and what explains them; the first that matches counts.
PATTERNS: tuple[Pattern, ...] = (
    (
        r"only integer scalar arrays can be converted to a scalar index",
        lambda match, source: (
            "np.concatenate reçoit les tableaux en une liste : np.concatenate([a, b])."
            if re.search(r"(?:concatenate|stack)\(", source)
            else _explain_index(match, source)
        ),
    ),
    (r"only integers, slices|arrays used as indices must be of integer|only integer scalar arrays", _explain_index),
    (r"(list|tuple|string|str|bytes) indices must be integers(?: or slices)?, not '?([\w.]+)'?", _explain_list_index),
    (
        r"slice indices must be integers",
        told("Les bornes d’une tranche a[i:j] doivent être des entiers : int(…), ou // pour une division entière."),
    ),
    (
        r"too many indices for array: array is (\d+)-dimensional, but (\d+) were indexed",
        lambda match, source: (
            f"Ce tableau a {plural(match[1], 'dimension')}, et {plural(match[2], 'indice')} lui sont donnés."
            if match[1] != "0"
            else "Cette valeur est un seul nombre (un tableau sans dimension) : elle n’a pas d’indice."
        ),
    ),
    (r"invalid index to scalar variable", _explain_indexed_scalar),
    (
        r"index (-?\d+) is out of bounds for axis (\d+) with size (\d+)",
        lambda match, source: (
            f"L’indice {match[1]} sort du tableau : l’axe {match[2]} a {plural(match[3], 'élément')}"
            + (", numérotés à partir de 0." if match[3] not in ("0", "1") else ".")
        ),
    ),
    (
        r"index (-?\d+) is out of bounds for (?:array with )?size (\d+)",
        told("L’indice {0} sort du tableau : il a {1} éléments, numérotés à partir de 0."),
    ),
    (
        r"boolean index did not match indexed array along axis (\d+); size of axis is (\d+) but size of corresponding "
        r"boolean axis is (\d+)",
        told("Ce masque de vrais et de faux a {2} éléments, et l’axe {0} du tableau en a {1} : il en faut autant."),
    ),
    (
        r"boolean index did not match",
        told("Un masque de vrais et de faux doit avoir la même forme que le tableau où il choisit."),
    ),
    (
        r"boolean array indexing assignment cannot assign (\d+) input values to the (\d+) output values",
        told("Le masque choisit {1} éléments, et {0} valeurs leur sont données : il en faut autant, ou une seule."),
    ),
    (
        r"shape mismatch: value array of shape (\([\d,]*\)) could not be broadcast to indexing result of shape "
        r"(\([\d,]*\))",
        lambda match, source: (
            f"Les valeurs ont la forme {shape(match[1])}, et les cases où elles vont, la forme {shape(match[2])}."
        ),
    ),
    (
        r"could not broadcast input array from shape (\([\d,]*\)) into shape (\([\d,]*\))",
        lambda match, source: (
            f"Ces tableaux n’ont pas des formes qui vont ensemble : {shape(match[1])} et {shape(match[2])} ; une "
            f"valeur "
            "de la première forme ne se range pas dans des cases de la seconde."
        ),
    ),
    (
        r"(list|tuple|string|bytearray) (?:assignment )?index out of range",
        told("Un indice sort de la liste : les indices vont de 0 à la longueur moins un."),
    ),
    (r"range object index out of range", told("Un indice sort du range : ils vont de 0 à la longueur moins un.")),
    (r"pop from (?:an )?empty", told("« pop » retire un élément, et il n’y en a plus aucun.")),
    (
        r"pop index out of range",
        told("« pop » reçoit un indice qui sort de la liste : ils vont de 0 à la longueur moins un."),
    ),
    (r"^solve\w*: .*core dimension 0.*\(size (\d+) is different from (\d+)\)", _explain_solve),
    (r"core dimension 0.*\(size (\d+) is different from (\d+)\)", _explain_matmul),
    (
        r"core dimension \d+.*\(size (\d+) is different from (\d+)\)",
        told("Ces tableaux n’ont pas des formes qui vont ensemble : {1} d’un côté, {0} de l’autre, au lieu d’autant."),
    ),
    (
        r"^(?:matmul|vecdot|matvec|vecmat): Input operand (\d+) does not have enough dimensions \(has (\d+)",
        lambda match, source: (
            f"« @ » est le produit de tableaux, et ce qui est à {'droite' if match[1] == '1' else 'gauche'} "
            + (
                "est un seul nombre : un produit par un nombre s’écrit « * »."
                if match[2] == "0"
                else "a trop peu de dimensions."
            )
        ),
    ),
    (r"shapes (\([\d,]*\)) and (\([\d,]*\)) not aligned: (\d+) \(dim \d+\) != (\d+)", _explain_dot),
    (r"could not be broadcast together with remapped shapes (.*)", _explain_remapped),
    (
        r"could not (?:be )?broadcast (?:together with |input array from )shapes? (.*)",
        lambda match, source: f"Ces tableaux n’ont pas des formes qui vont ensemble : {_operand_shapes(match[1])}.",
    ),
    (
        r"non-broadcastable output operand with shape (\([\d,]*\)) doesn't match the broadcast shape (\([\d,]*\))",
        lambda match, source: (
            f"Le résultat a la forme {shape(match[2])}, et le tableau de forme {shape(match[1])} ne peut pas le "
            f"recevoir "
            "sur place : a = a + b en fait un nouveau."
        ),
    ),
    (
        r"shape mismatch: objects cannot be broadcast to a single shape.*?shape (\([\d,]*\)).*?shape (\([\d,]*\))",
        lambda match, source: f"Ces formes ne vont pas ensemble : {shape(match[1])} et {shape(match[2])}.",
    ),
    (
        r"along dimension (\d+), the array at index \d+ has size (\d+) and the array at index \d+ has size (\d+)",
        _explain_ends,
    ),
    (
        r"all the input array dimensions .* must match exactly",
        told("Les tableaux mis bout à bout doivent avoir les mêmes dimensions, sauf celle où ils se suivent."),
    ),
    (
        r"must have same number of dimensions, but the array at index (\d+) has (\d+) dimension.* index (\d+) has "
        r"(\d+)",
        lambda match, source: (
            "Les tableaux mis bout à bout doivent avoir autant de dimensions : "
            f"l’un en a {match[2]}, un autre {match[4]} (v[None, :] fait d’un vecteur une ligne)."
        ),
    ),
    (
        r"zero-dimensional arrays cannot be concatenated",
        told("np.concatenate met bout à bout des tableaux, et reçoit de simples nombres : np.array([…]) en fait un."),
    ),
    (r"need at least one array to", told("Il faut au moins un tableau à assembler, et la liste est vide.")),
    (
        r"all input arrays must have the same shape",
        told("Les tableaux empilés doivent avoir tous la même forme."),
    ),
    (
        r"cannot reshape array of size (\d+) into shape (\([\w,]*\))",
        lambda match, source: (
            f"{match[1]} valeurs ne remplissent pas la forme "
            f"{re.sub(',(?=.)', ', ', match[2].replace('newaxis', '-1'))}."
        ),
    ),
    (
        r"can only specify one unknown dimension",
        told("Une forme ne peut avoir qu’un seul -1 : un seul axe se déduit des autres."),
    ),
    (
        r"inhomogeneous shape|setting an array element with a sequence",
        told("Toutes les lignes d’un tableau doivent avoir la même longueur, et chaque case un seul nombre."),
    ),
    (r"axis (-?\d+) is out of bounds for array of dimension (\d+)", _explain_axis),
    (r"axes don't match array", told("Il faut autant d’axes que le tableau a de dimensions, chacun une fois.")),
    (r"repeated axis|duplicate value in 'axis'", told("Un même axe est donné deux fois.")),
    (
        r"cannot select an axis to squeeze out",
        told("« squeeze » retire un axe d’un seul élément, et celui-ci en a plusieurs."),
    ),
    (
        r"array split does not result in an equal division",
        told("Le tableau ne se coupe pas en parts égales : np.array_split accepte des parts inégales."),
    ),
    (
        r"(\d+)-dimensional array given\. Array must be(?: at least)? (?:two|2)-dimensional",
        lambda match, source: f"Il faut une matrice, un tableau à deux dimensions : celui-ci en a {match[1]}.",
    ),
    (
        r"must be square|expected square|must be 2 dimensional and square",
        told("Il faut une matrice carrée, autant de lignes que de colonnes."),
    ),
    (
        r"[Ss]ingular matrix|singular matrix detected|matrix is (?:exactly )?singular",
        told("La matrice est singulière, sans inverse : deux de ses lignes disent-elles la même chose ?"),
    ),
    (
        r"not positive.definite",
        told(
            "La matrice n’est pas définie positive : une covariance doit être symétrique, et de variances strictement "
            "positives."
        ),
    ),
    (r"did not converge", told("Le calcul matriciel ne converge pas : la matrice contient-elle nan ou un infini ?")),
    (
        r"infs or NaNs|non-?finite|not finite|inf or NaN",
        told("Un des nombres est nan ou infini : une division par zéro, ou le logarithme de zéro, avant cette ligne ?"),
    ),
    (
        r"[Ii]ncompatible dimensions for cross product",
        told("Un produit vectoriel se fait entre vecteurs de longueur 2 ou 3."),
    ),
    (
        r"^[Ii]ncompatible (?:dimensions|shapes)|[Ss]hape mismatch|shapes? of .* (?:are|is) incompatible|dimension "
        r"mismatch",
        told("Les deux tableaux n’ont pas autant de lignes : leurs formes ne vont pas ensemble."),
    ),
    (
        r"must be (?:at least )?(?:1-?d|one.?dimensional|1-dimensional)|at least one dimensional|object too deep|"
        r"too deep for desired array",
        told("Il faut ici un vecteur, un tableau à une dimension : a.ravel() en fait un, a[0] en prend une ligne."),
    ),
    (
        r"at least (?:two|2).?-?d(?:imension)?|at least 2-d|at least two dimensions",
        told("Il faut ici une matrice, un tableau à deux dimensions au moins."),
    ),
    (r"must be 1- or 2-d", told("Il faut ici un vecteur ou une matrice (une ou deux dimensions).")),
    (
        r"nonzero on 0d arrays",
        told("Cette fonction cherche dans un tableau, et reçoit un seul nombre : np.atleast_1d(x)."),
    ),
    (
        r"[Xx] must consist of vectors of length (\d+) but has shape (\([\d,]*\))",
        lambda match, source: (
            f"Les points ont {match[1]} coordonnées, et ce qui est cherché a la forme {shape(match[2])}."
        ),
    ),
    (
        r"einstein sum|operand has more dimensions than subscripts|output string",
        told("Les lettres de np.einsum ne vont pas avec les tableaux : une lettre par dimension de chacun."),
    ),
    (
        r"'NoneType' object is not (?:subscriptable|iterable)|cannot unpack non-iterable NoneType",
        told(f"Cette valeur est None : {OR_NONE}"),
    ),
)
