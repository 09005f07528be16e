"""What a proposed mistake is called and how it is explained, by the kind of the change: nothing of the solution."""

from __future__ import annotations

from graders.core.declared.body_changes import CONSTANT, PREPARED, UNREAD
from graders.core.declared.call_changes import LIST_END, LOOK, ONCE, RAW_TEXT, SORTED

_ALIKE = "Votre programme répond comme un programme juste dont {what} : {advice}"
_STEP = (
    "Une étape est fausse, ou manque",
    "une étape serait fausse, ou manquerait",
    "suivez-le à la main sur l’exemple.",
)
#: The title of a mistake, what is wrong, and what to look at.
_WORDS = {
    "comparaison": (
        "Une comparaison est fausse",
        "une comparaison serait fausse",
        "relisez vos <, <=, > et >=, surtout pour deux valeurs égales.",
    ),
    "opérateur": (
        "Une opération est fausse",
        "une opération serait fausse",
        "relisez vos +, -, *, / et ** sur un petit exemple.",
    ),
    "terme oublié": (
        "Un terme est oublié",
        "un terme d’un calcul serait oublié",
        "comparez vos formules à l’énoncé, terme par terme.",
    ),
    "instruction oubliée": (
        "Une instruction est oubliée",
        "une instruction serait oubliée",
        "cherchez ce que l’énoncé demande de faire, et que votre programme ne fait pas.",
    ),
    "appel oublié": (
        "Un appel est oublié",
        "un appel de fonction serait oublié",
        "cherchez la valeur qui devrait passer par une fonction.",
    ),
    "constante": (
        "Une constante est fausse",
        "un nombre écrit dans le programme serait faux",
        "vérifiez vos valeurs de départ et les nombres de vos formules.",
    ),
    "indice décalé": (
        "Un indice est décalé",
        "un indice serait décalé d’une place",
        "écrivez la liste et ses indices, qui partent de 0.",
    ),
    "intervalle décalé": (
        "Un intervalle est décalé",
        "une boucle commencerait ou finirait une étape trop tôt, ou trop tard",
        "écrivez les valeurs que prend sa variable : range(a, b) s’arrête avant b.",
    ),
    "borne oubliée": (
        "Une borne est oubliée",
        "une borne serait oubliée",
        "vérifiez le premier et le dernier élément.",
    ),
    "condition": (
        "Une condition est fausse",
        "une condition serait fausse",
        "cherchez une valeur pour laquelle votre if ou votre while se trompe.",
    ),
    "condition oubliée": (
        "Une condition est oubliée",
        "une condition serait oubliée",
        "cherchez le cas de l’énoncé que votre programme ne traite pas à part.",
    ),
    "et, ou": (
        "Une condition est fausse",
        "« et » serait pris pour « ou »",
        "écrivez pour quelles valeurs votre condition est vraie.",
    ),
    "branche": (
        "Un cas est traité comme un autre",
        "un cas serait traité comme un autre",
        "suivez un exemple de chaque cas de l’énoncé.",
    ),
    "affectation": (
        "Une affectation est fausse",
        "une variable serait remplacée au lieu d’être augmentée, ou l’inverse",
        "suivez sa valeur d’un tour de boucle à l’autre.",
    ),
    "fonction voisine": (
        "Une autre fonction est appelée",
        "une fonction serait prise pour une autre",
        "relisez ce que fait chaque fonction que vous appelez.",
    ),
    "argument oublié": (
        "Un argument est oublié",
        "un argument serait oublié dans un appel",
        "relisez ce que prend chaque fonction que vous appelez.",
    ),
    "arguments échangés": (
        "Deux arguments sont échangés",
        "deux arguments d’un appel seraient échangés",
        "relisez l’ordre de ce que prend chaque fonction que vous appelez.",
    ),
    "opérandes échangés": (
        "Deux termes sont échangés",
        "deux termes seraient échangés",
        "a - b n’est pas b - a, ni a / b, b / a.",
    ),
    "ordre": (
        "Deux instructions sont échangées",
        "deux instructions seraient échangées",
        "une valeur change peut-être avant qu’on s’en serve.",
    ),
    "signe ou négation oubliés": (
        "Un signe est oublié",
        "un signe, ou un « not », serait oublié",
        "vérifiez-le sur un exemple négatif ou faux.",
    ),
    "variable": (
        "Une variable est prise pour une autre",
        "une variable serait prise pour une autre",
        "relisez vos noms, ligne par ligne.",
    ),
    LIST_END: (
        "Le mauvais bout de la liste",
        "on prendrait, ou mettrait, au mauvais bout de la liste",
        "dites de quel bout l’énoncé parle.",
    ),
    LOOK: (
        "Un élément est lu sans être retiré",
        "un élément serait lu sans être retiré",
        "regardez ce que contient la liste après l’appel.",
    ),
    ONCE: (
        "Une valeur déjà là n’est pas ajoutée",
        "une valeur déjà présente ne serait pas ajoutée",
        "l’énoncé demande de l’ajouter à chaque fois.",
    ),
    SORTED: (
        "Les valeurs sont rangées",
        "les valeurs seraient rangées à mesure qu’on les ajoute",
        "l’énoncé demande l’ordre dans lequel elles arrivent.",
    ),
    RAW_TEXT: (
        "Le texte est lu comme il est tapé",
        "le texte serait lu comme il est tapé",
        "pensez aux majuscules et aux espaces.",
    ),
    CONSTANT: (
        "Le résultat est toujours le même",
        "le résultat serait toujours le même",
        "essayez-le sur deux entrées différentes.",
    ),
    UNREAD: (
        "Un paramètre n’est pas utilisé",
        "un paramètre ne servirait pas",
        "changez-le seul, et regardez si le résultat change.",
    ),
    PREPARED: (
        "Ce qui est donné est changé d’abord",
        "ce qui est donné serait changé avant de servir",
        "l’énoncé demande de le prendre comme il est.",
    ),
}


def title_for_operator(operator: str) -> str:
    """Return what a mistake is called, by the kind of the change."""
    return _WORDS.get(operator, _STEP)[0]


def explanation_for_operator(operator: str) -> str:
    """Return an explanation of a mistake, which its author may reword: true of every program that answers alike."""
    _, what, advice = _WORDS.get(operator, _STEP)
    return _ALIKE.format(what=what, advice=advice)
