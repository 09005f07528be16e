"""Values that a function of Python, numpy or scipy refuses: an empty list, a text that is no number, a bad "
"probability."""

from __future__ import annotations

import re

from server.sandbox.explanations.patterns import Pattern, called_function, told
from server.sandbox.explanations.types import describe_type

_OUTSIDE = "Cette fonction n’existe pas pour cette valeur"


#: What a field of a ROS message takes, by its type in Python.
_FIELDS = {
    "float": "un nombre à virgule : 0.0 ou float(…), et non 0",
    "int": "un entier : int(…)",
    "str": "une chaîne de caractères",
    "bool": "True ou False",
}


def _explain_field(match: re.Match[str], source: str) -> str:
    return f"Le champ {match[1]} de ce message reçoit {_FIELDS.get(match[2], f'une valeur de type {match[2]}')}."


def _explain_domain(match: re.Match[str], source: str) -> str:
    function = called_function(source)
    why = {
        "math.sqrt": "la racine d’un nombre négatif",
        "math.log": "le logarithme d’un nombre négatif ou nul",
        "math.log10": "le logarithme d’un nombre négatif ou nul",
        "math.log2": "le logarithme d’un nombre négatif ou nul",
        "math.acos": "l’arc cosinus d’un nombre hors de [−1, 1], parfois d’un cheveu : np.clip(c, -1, 1)",
        "math.asin": "l’arc sinus d’un nombre hors de [−1, 1], parfois d’un cheveu : np.clip(s, -1, 1)",
    }
    if function in why and source.count(function) == 1 and source.count("math.") == 1:
        return f"{_OUTSIDE} : {why[function]}."
    return f"{_OUTSIDE} : racine ou logarithme d’un négatif, acos au-delà de 1 ?"


def _explain_number_text(match: re.Match[str], source: str) -> str:
    written = match[1]
    inside = written.strip("'\"")
    if "," in inside and inside.replace(",", ".", 1).replace(".", "", 1).lstrip("+-").isdigit():
        return (
            f"{written} n’est pas l’écriture d’un nombre : le séparateur décimal est le point, "
            f"{inside.replace(',', '.')}."
        )
    return f"{written} n’est pas l’écriture d’un nombre (le séparateur décimal est le point)."


def _explain_integer_text(match: re.Match[str], source: str) -> str:
    written = match[1]
    if written.strip("'\"").replace(".", "", 1).lstrip("+-").isdigit():
        return f"{written} n’est pas l’écriture d’un entier : int(float(…)) tronque un nombre à virgule."
    return f"{written} n’est pas l’écriture d’un entier."


def _explain_format(match: re.Match[str], source: str) -> str:
    kind = next((group for group in match.groups() if group), "")
    what = describe_type(kind)
    if "ndarray" in kind or kind in ("list", "tuple"):
        return f"Ce format écrit un nombre, et c’est {what} : un élément, v[0], ou np.round(v, 2)."
    return f"Ce format écrit un nombre, et c’est {what}."


def _explain_empty(match: re.Match[str], source: str) -> str:
    function = called_function(source) or "Cette fonction"
    return f"{function} cherche dans des valeurs, et il n’y en a aucune : la liste ou le tableau est vide."


#: Texts of libraries about the values of arguments, and what explains them; the first that matches counts.
PATTERNS: tuple[Pattern, ...] = (
    (r"could not convert string to float: (.*)", _explain_number_text),
    (r"invalid literal for int\(\) with base \d+: (.*)", _explain_integer_text),
    (r"complex\(\) arg is a malformed string", told("Cette chaîne n’est pas l’écriture d’un nombre complexe.")),
    (
        r"cannot convert float NaN to integer",
        told(
            "nan n’est pas un nombre, et n’a pas d’entier : une division 0/0, ou la racine d’un négatif, avant "
            "cette ligne ?"
        ),
    ),
    (
        r"cannot convert float infinity to integer",
        told("Une valeur infinie n’a pas d’entier : une division par zéro avant cette ligne ?"),
    ),
    (r"math domain error|expected a (?:nonnegative|positive|noninteger|number in range)", _explain_domain),
    (
        r"math range error|Numerical result out of range|int too large to convert to float|"
        r"integer division result too large|too large to convert",
        told("Le résultat est un nombre trop grand : une exponentielle, ou une puissance, s’emballe-t-elle ?"),
    ),
    (r"factorial\(\) not defined for negative", told(f"{_OUTSIDE} : la factorielle d’un nombre négatif.")),
    (
        r"arg is an empty sequence|zero-size array to reduction|attempt to get arg\w+ of an empty sequence|"
        r"iterable argument is empty|mean requires at least one|no median for empty data",
        _explain_empty,
    ),
    (
        r"Cannot choose from an empty|cannot be empty unless no samples|a must be (?:greater than 0|non-empty)",
        told("Le tirage se fait dans une liste vide : il n’y a rien à tirer."),
    ),
    (r"range\(\) arg 3 must not be zero|slice step cannot be zero", told("Le pas ne peut pas être nul.")),
    (r"negative dimensions are not allowed", told("Un tableau ne peut pas avoir une taille négative.")),
    (r"Number of samples, -?\d+, must be non-negative", told("Le nombre de points ne peut pas être négatif.")),
    (r"Maximum allowed size exceeded", told("Ce tableau aurait trop d’éléments : le pas est-il presque nul ?")),
    (
        r"Integers to negative integer powers",
        told("numpy n’élève pas des entiers à une puissance négative : a.astype(float) ** -1, ou 1 / a."),
    ),
    (
        r"[Pp]robabilities do not sum to 1",
        told("Les probabilités p doivent avoir 1 pour somme : divisez-les par p.sum()."),
    ),
    (r"[Pp]robabilities are not non-negative", told("Une des probabilités p est négative.")),
    (r"[Pp]robabilities contain NaN", told("Une des probabilités p est nan : une division 0/0 avant cette ligne ?")),
    (r"pvals|sum\(pvals", told("Les probabilités doivent être positives et avoir 1 pour somme au plus.")),
    (
        r"[\"'`]?a[\"'`]? and [\"'`]?p[\"'`]? must have same size",
        told("np.random.choice demande autant de probabilités p que d’éléments où tirer."),
    ),
    (
        r"larger sample than population|Sample larger than population",
        told("Le tirage sans remise demande plus d’éléments qu’il n’y en a."),
    ),
    (r"number of weights does not match", told("Il faut autant de poids que d’éléments.")),
    (r"Total of weights must be", told("La somme des poids doit être strictement positive, et finie.")),
    (
        r"Fewer non-zero entries in p",
        told("Le tirage sans remise demande plus d’éléments qu’il n’y en a de probables."),
    ),
    (r"^(?:scale|sigma|std) ?< ?0", told("Un écart-type ne peut pas être négatif.")),
    (r"^low >= high|^low > high|empty range for rand", told("La borne basse du tirage doit être sous la borne haute.")),
    (r"^(\w+) (?:<=?|>=?) ?-?[\d.]+$", told("Un paramètre de la loi du tirage est hors de ses bornes : {0}.")),
    (r"cov must be 2", told("La covariance est une matrice carrée, de la taille de la moyenne.")),
    (r"mean and cov must have same length", told("La moyenne et la covariance n’ont pas la même taille.")),
    (r"mean must be 1", told("La moyenne est un vecteur.")),
    (
        r"either both or neither of x and y",
        told("np.where prend une condition seule, ou une condition et deux valeurs."),
    ),
    (r"fp and xp are not of the same length", told("np.interp demande autant d’abscisses xp que d’ordonnées fp.")),
    (r"array of sample points is empty", told("np.interp demande au moins un point.")),
    (
        r"x and y arrays must be equal in length|x and y must have (?:the )?same|expected x and y to have same length|"
        r"must be (?:of )?(?:the )?same (?:length|size|shape)|must have the same (?:length|shape|size)",
        told("Il faut autant d’éléments dans les deux tableaux."),
    ),
    (
        r"Axis must be specified when shapes of a and weights differ|Length of weights not compatible",
        told("Il faut autant de poids que de valeurs."),
    ),
    (r"Weights sum to zero", told("La somme des poids est nulle : la moyenne pondérée n’existe pas.")),
    (
        r"f\(a\) and f\(b\) must have different signs",
        told("La fonction doit changer de signe entre les deux bornes : il n’y a peut-être pas de zéro entre elles."),
    ),
    (r"must be strictly increasing|must increase monotonically", told("Ces valeurs doivent aller en croissant.")),
    (r"`bins` must be positive", told("Le nombre de classes (bins) est un entier strictement positif.")),
    (
        r"autodetected range of .* is not finite",
        told("Un des nombres est nan ou infini : l’histogramme ne sait où s’arrêter."),
    ),
    (
        r"max must be larger than min in range",
        told("Les bornes de l’histogramme vont de la plus petite à la plus grande."),
    ),
    (r"invalid entry in (?:coordinates|choice) array", told("Un indice sort du tableau.")),
    (r"index can't contain negative values", told("Une largeur ne peut pas être négative.")),
    (
        r"(?:array|assignment destination|output array) is read-only",
        told("Ce tableau ne se modifie pas : a.copy() en fait un autre."),
    ),
    (
        r"only one element tensors|cannot call `vectorize` on size 0",
        told("np.vectorize ne sait quel type donner à un résultat vide."),
    ),
    (r"Expecting at least two arrays", told("Il faut au moins deux tableaux.")),
    (r"could not be read to its end|buffer size must be a multiple", told("Ce texte n’est pas une suite de nombres.")),
    (r"Error parsing datetime", told("Ce texte n’est pas une date.")),
    (r"^(.+) is not in (?:list|deque)", told("{0} n’est pas dans la liste.")),
    (r"x not in (list|tuple|deque)|not in tuple", told("Cette valeur n’est pas dans la liste.")),
    (r"substring not found|subsection not found", told("Ce morceau n’est pas dans la chaîne.")),
    (r"empty separator", told("« split » demande un séparateur d’au moins un caractère.")),
    (
        r"sequence item \d+: expected str instance, (\w+) found",
        lambda match, source: (
            f"« join » assemble des chaînes, et l’une est {describe_type(match[1])} : str(…) en fait une chaîne."
        ),
    ),
    (r"can only join an iterable", told("« join » assemble les éléments d’une liste.")),
    (
        r"not all arguments converted during string formatting",
        told("« % » met une valeur dans une chaîne, et elle n’a pas de place (%s, %d…) pour celle-ci."),
    ),
    (r"not enough arguments for format string", told("La chaîne a plus de places (%s, %d…) que de valeurs données.")),
    (r"Replacement index \d+ out of range", told("La chaîne a plus de places {{}} que de valeurs données à format.")),
    (r"Unknown format code '.' for object of type '(\w+)'", _explain_format),
    (r"unsupported format string passed to ([\w.]+)\.__format__", _explain_format),
    (r"[Ii]nvalid format specifier|[Uu]nsupported format character|incomplete format", told("Ce format n’existe pas.")),
    (r"ord\(\) expected", told("ord(…) attend un seul caractère.")),
    (r"chr\(\) arg not in range", told("Aucun caractère n’a ce numéro.")),
    (r"bytes must be in range", told("Un octet va de 0 à 255.")),
    (r"int\(\) base must be", told("La base va de 2 à 36.")),
    (r"can't convert non-string with explicit base", told("int(texte, base) lit une chaîne de caractères.")),
    (r"pow\(\) 3rd argument cannot be 0", told("Le modulo ne peut pas être nul.")),
    (
        r"cannot convert dictionary update sequence|dictionary update sequence element",
        told("dict(…) attend des couples (clé, valeur)."),
    ),
    (
        r"popitem\(\): dictionary is empty|pop from an empty set",
        told("Il n’y a plus rien à retirer : tout est déjà parti."),
    ),
    (
        r"(dictionary|set|deque|list) (?:changed size|keys changed|mutated|modified) during iteration|changed "
        r"during iteration",
        told("Cette collection change pendant que la boucle la parcourt : parcourez une copie, list(…)."),
    ),
    (
        r"Exceeds the limit \((\d+) digits\) for integer string conversion",
        told("Cet entier a plus de {0} chiffres : il est trop long pour être écrit."),
    ),
    (r"The '([\w.]+)' field must be of type '(\w+)'", _explain_field),
    (r"The '([\w.]+)' field must be a sub message of type '([\w.]+)'", told("Le champ {0} reçoit un message {1}.")),
    (
        r"The '([\w.]+)' field must be .*? in (\[[^\]]*\])",
        told("Le champ {0} reçoit un nombre de l’intervalle {1}, et celui-ci en sort."),
    ),
    (r"super\(\): ", told("« super » n’a de sens que dans la méthode d’une classe.")),
    (
        r"generator already executing|coroutine",
        told("Cette fonction « async » ne s’appelle pas comme les autres : retirez « async »."),
    ),
    (
        r"(?:codec can't|unknown encoding|invalid start byte|invalid continuation byte)",
        told("Ce texte ne se lit ou ne s’écrit pas dans cet encodage : UTF-8 les connaît tous."),
    ),
)
