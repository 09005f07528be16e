# ruff: noqa: E501
"""The kinds of small exercise that a declaration must express: a declaration, a right program of another style, wrong
ones with what their verdict must say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

#: The solution of an exercise that asks for a class.
STACK = """class Pile:
    def __init__(self):
        self.t = []
    def empiler(self, x):
        self.t.append(x)
    def depiler(self):
        return self.t.pop()
    def est_vide(self):
        return not self.t
"""


@dataclass(frozen=True)
class Kind:
    """One kind: `right` are programs unlike the solution, `wrong` maps a program to words of its first message."""

    name: str
    declaration: dict[str, Any]
    right: tuple[str, ...]
    wrong: dict[str, str]


def declare(functions: str, solution: str, *cases: str, **more: Any) -> dict[str, Any]:
    """Return a declaration of one check; keys of the check and of the declaration are told apart by name."""
    whole = {key: more.pop(key) for key in ("interdits", "demandes", "erreurs") if key in more}
    check = {"id": "exemples", "titre": "Les exemples", "points": 20, "cas": list(cases), **more}
    return {"fonctions": functions.split(), "solution": solution, "verifications": [check], **whole}


KINDS = (
    Kind(
        "function",
        declare("aire", "def aire(a, b):\n    return a * b\n", "aire(2, 3)", tirages="a = entier(0, 9); b = entier(0, 9)",
                appel="aire(a, b)"),
        ("aire = lambda x, y: sum(x for _ in range(y))\n",),
        {"def aire(a, b):\n    return a + b\n": "Pour aire(2, 3), on attend 6 et aire renvoie 5."},
    ),
    Kind(
        "text",
        declare("initiales", "def initiales(nom):\n    return ''.join(m[0] for m in nom.split())\n",
                'initiales("")', 'initiales("Ada Lovelace")'),
        ("def initiales(nom):\n    r = ''\n    for m in nom.split():\n        r += m[0]\n    return r\n",),
        {"def initiales(nom):\n    return nom[0] if nom else ' '\n": "Pour initiales(''), on attend '' et initiales renvoie ' '."},
    ),
    Kind(
        "dict",
        declare("mots", "def mots(t):\n    d = {}\n    for m in t.split():\n        d[m] = d.get(m, 0) + 1\n    return d\n",
                'mots("")', 'mots("a b a")'),
        ("from collections import Counter\ndef mots(t):\n    return Counter(t.split())\n",),
        {"def mots(t):\n    return {m: t.split(' ').count(m) for m in t.split(' ')}\n":
         "Pour mots(''), on attend {} et mots renvoie {'': 1}.",
         "def mots(t):\n    return {m: 1 for m in t.split()}\n": "Pour la clé 'a' : 1 au lieu de 2."},
    ),
    Kind(
        "set",
        declare("communs", "def communs(a, b):\n    return a & b\n", "communs({1, 2}, {2, 3})", "communs(set(), {1})"),
        ("def communs(a, b):\n    return {x for x in a if x in b}\n",),
        {"def communs(a, b):\n    return a | b\n": "on attend {2} et communs renvoie {1, 2, 3}",
         "def communs(a, b):\n    return [x for x in a if x in b]\n": "On attend un ensemble, pas une liste."},
    ),
    Kind(
        "None",
        declare("chercher", "def chercher(t, x):\n    return t.index(x) if x in t else None\n",
                "chercher([3, 4], 4)", "chercher([], 1)"),
        ("def chercher(t, x):\n    for i, y in enumerate(t):\n        if y == x:\n            return i\n",),
        {"def chercher(t, x):\n    return t.index(x) if x in t else -1\n": "on attend None et chercher renvoie -1"},
    ),
    Kind(
        "exception",
        declare("racine", "def racine(x):\n    if x < 0:\n        raise ValueError('x < 0')\n    return x ** 0.5\n",
                "racine(4.0)", "racine(-1.0)"),
        ("class Negatif(ValueError):\n    pass\ndef racine(x):\n    assert True\n    if x < 0:\n        raise ValueError\n"
         "    return x ** 0.5\n",),
        {"def racine(x):\n    return abs(x) ** 0.5\n": "on attend l’exception ValueError et racine renvoie 1.0",
         "def racine(x):\n    if x < 0:\n        raise TypeError\n    return x ** 0.5\n": "l’exception TypeError"},
    ),
    Kind(
        "class",
        declare("Pile", "class Pile:\n    def __init__(self):\n        self.t = []\n    def empiler(self, x):\n        self.t.append(x)\n"
                "    def depiler(self):\n        return self.t.pop()\n    def taille(self):\n        return len(self.t)\n",
                "p = Pile(); p.empiler(3); p.empiler(4); p.depiler(); p.taille()"),
        ("class Pile(list):\n    def empiler(self, x):\n        self.append(x)\n        return self\n    depiler = list.pop\n"
         "    taille = list.__len__\n",),
        {"class Pile:\n    def __init__(self):\n        self.t = []\n    def empiler(self, x):\n        self.t.append(x)\n"
         "    def depiler(self):\n        return self.t.pop(0)\n    def taille(self):\n        return len(self.t)\n":
         "p.depiler() doit donner 4 et donne 3"},
    ),
    Kind(
        "exception of a method",
        declare("Pile", "class Pile:\n    def __init__(self):\n        self.t = []\n    def depiler(self):\n        return self.t.pop()\n",
                "p = Pile(); p.depiler()"),
        ("class Pile(list):\n    depiler = list.pop\n",),
        {"class Pile:\n    def depiler(self):\n        return -1\n":
         "on attend l’exception IndexError et p.depiler() renvoie -1. Aucune exception",
         "class Pile:\n    def depiler(self):\n        pass\n":
         "on attend l’exception IndexError et p.depiler() renvoie None. Aucune exception"},
    ),
    Kind(
        "generator",
        declare("pairs", "def pairs(n):\n    for k in range(0, n, 2):\n        yield k\n", "pairs(7)", "list(pairs(0))"),
        ("def pairs(n):\n    return (k for k in range(n) if k % 2 == 0)\n", "def pairs(n):\n    return list(range(0, n, 2))\n"),
        {"def pairs(n):\n    yield from range(1, n, 2)\n": "on attend [0, 2, 4, 6] et pairs renvoie [1, 3, 5]"},
    ),
    Kind(
        "recursion",
        declare("fact", "def fact(n):\n    return 1 if n == 0 else n * fact(n - 1)\n", "fact(0)", "fact(5)",
                demandes=["recursion"], interdits=["boucle"]),
        ("def aide(n):\n    return fact(n)\ndef fact(n):\n    if not n:\n        return 1\n    return n * aide(n - 1)\n",),
        {"def fact(n):\n    r = 1\n    for k in range(2, n + 1):\n        r *= k\n    return r\n": "ne permet pas une boucle",
         "import math\ndef fact(n):\n    return math.factorial(n)\n": "demande une fonction qui s’appelle elle-même"},
    ),
    Kind(
        "printed text",
        declare("saluer", "def saluer(nom):\n    print('Bonjour', nom)\n", 'saluer("Ada")', regarder="affichage"),
        ("def saluer(nom):\n    print(f'Bonjour {nom}  ')\n    print()\n",),
        {"def saluer(nom):\n    return 'Bonjour ' + nom\n": "Rien n’est affiché",
         "def saluer(nom):\n    print('bonjour', nom)\n": "'bonjour Ada"},
    ),
    Kind(
        "standard input",
        declare("somme", "def somme():\n    print(int(input()) + int(input()))\n", "somme()", regarder="affichage",
                entrees=["3", "4"]),
        ("import sys\ndef somme():\n    print(sum(map(int, sys.stdin)))\n",),
        {"def somme():\n    print(input() + input())\n": "on attend l’affichage '7"},
    ),
    Kind(
        "typed lines",
        declare("somme", "def somme():\n    return int(input()) + int(input())\n", 'clavier("3", 4); somme()',
                tirages="a = entier(0, 9)", appel="clavier(a, 5); somme()"),
        ("import sys\ndef somme():\n    return sum(map(int, sys.stdin))\n",
         "def somme():\n    return int(input('a ? ')) + int(input('b ? '))\n"),
        {"def somme():\n    return input() + input()\n": "Dans « clavier('3', 4); somme() », somme() doit donner 7 et donne '34'."},
    ),
    Kind(
        "whole program",
        declare("programme", "a, b = int(input('a ? ')), int(input())\nprint('somme', a + b)\n", 'programme("3", "4")',
                tirages="a = entier(0, 9)", appel="programme(a, a)", attendus=["a ? 3\n4\nsomme 7"]),
        ("import sys\nif __name__ == '__main__':\n    print('somme', sum(map(int, sys.stdin.read().split())))\n    exit()\n",
         "def main():\n    print('a ? ', end='')\n    print('somme', int(input()) + int(input()))\nmain()\n"),
        {"print('somme', input() + input())\n": "Quand on tape « 3 », puis « 4 », on attend l’affichage 'somme 7\\n', et c’est 'somme 34\\n'.",
         "def somme():\n    return int(input()) + int(input())\n": "Rien n’est affiché",
         "while True:\n    print('somme', input())\n": "plus de ligne à lire",
         "": "Rien n’est affiché"},
    ),
    Kind(
        "variable of a program",
        declare("programme", "import sys\nn = len(sys.argv) - 1\ndef double(x):\n    return 2 * x\n",
                'arguments("-a", "-b"); programme(); n', "programme(); double(3)", attendus=["2", "6"]),
        ("from sys import argv\nn = 0\nfor _ in argv[1:]:\n    n += 1\ndef double(x):\n    return x + x\n",),
        {"n = 2\n": "n’existe pas", "n = 1\ndef double(x):\n    return 2 * x\n": "n doit donner 2 et donne 1"},
    ),
    Kind(
        "chained calls and attributes",
        declare("Pile depiler", "class Pile:\n    def __init__(self):\n        self.t = []\n    def empiler(self, x):\n"
                "        self.t.append(x)\n        return self\ndef depiler(p):\n    return p.t.pop()\n",
                "depiler(Pile().empiler(1).empiler(2))", "p = Pile(); p.t = [5]; print(depiler(p.empiler(3))); p.t"),
        ("class Pile(list):\n    def empiler(self, x):\n        self.t = getattr(self, 't', []) + [x]\n        return self\n"
         "def depiler(p):\n    *p.t, x = p.t\n    return x\n",),
        {"class Pile:\n    def __init__(self):\n        self.t = []\n    def empiler(self, x):\n        self.t.append(x)\n"
         "def depiler(p):\n    return p.t.pop()\n": "empiler"},
    ),
    Kind(
        "file read by a program",
        declare("programme", "print(len(open('notes.txt').readlines()))\n", 'fichier("notes.txt", "a\\nb\\n"); programme()',
                'fichier("notes.txt", ""); programme()'),
        ("from pathlib import Path\nprint(Path('notes.txt').read_text().count('\\n'))\n",),
        {"print(2)\n": "Quand on lance le programme avec « notes.txt », on attend l’affichage '0\\n', et c’est '2\\n'."},
    ),
    Kind(
        "file written",
        declare("copier", "def copier(a, b):\n    with open(a) as f, open(b, 'w') as g:\n        g.write(f.read().upper())\n",
                'fichier("a.txt", "bon"); copier("a.txt", "b.txt")', regarder="fichiers", attendus=['{"b.txt": "BON"}']),
        ("def copier(a, b):\n    f = open(b, 'wb')\n    f.write(open(a).read().upper().encode())\n",),
        {"def copier(a, b):\n    return open(a).read().upper()\n": "Le fichier « b.txt » n’est pas écrit.",
         "def copier(a, b):\n    with open(b, 'w') as g:\n        g.write(open(a).read())\n": "Dans « b.txt »"},
    ),
    Kind(
        "file read",
        declare("lignes", "def lignes(nom):\n    with open(nom) as f:\n        return len(f.readlines())\n",
                'lignes("notes.txt")', fichiers={"notes.txt": "a\nb\n"}),
        ("def lignes(nom):\n    return open(nom, 'rb').read().count(b'\\n')\n",),
        {"def lignes(nom):\n    return len(open(nom).read())\n": "on attend 2 et lignes renvoie 4"},
    ),
    Kind(
        "forbidden construct",
        declare("trier", "def trier(t):\n    r = []\n    for x in t:\n        k = 0\n        while k < len(r) and r[k] < x:\n"
                "            k += 1\n        r.insert(k, x)\n    return r\n", "trier([3, 1, 2])", interdits=["sorted", "sort"]),
        ("def trier(t):\n    t = list(t)\n    r = []\n    while t:\n        r.append(min(t))\n        t.remove(min(t))\n    return r\n",),
        {"def trier(t):\n    return sorted(t)\n": "Ligne 2 : l’énoncé ne permet pas `sorted`."},
    ),
    Kind(
        "required construct",
        declare("carres", "def carres(n):\n    return [k * k for k in range(n)]\n", "carres(4)", demandes=["comprehension"]),
        ("def carres(n):\n    return list(k ** 2 for k in range(n))\n",),
        {"def carres(n):\n    r = []\n    for k in range(n):\n        r.append(k * k)\n    return r\n": "une liste en compréhension"},
    ),
    Kind(
        "float tolerance",
        declare("dichotomie", "def dichotomie(f, a, b, eps):\n    while b - a > eps:\n        m = (a + b) / 2\n"
                "        if f(a) * f(m) <= 0:\n            b = m\n        else:\n            a = m\n    return (a + b) / 2\n",
                "dichotomie(lambda x: x * x - 2, 0, 2, 1e-6)", tolerance=1e-6, absolue=True),
        ("def dichotomie(f, a, b, eps):\n    while b - a > eps / 10:\n        m = a + (b - a) / 2\n"
         "        a, b = (a, m) if f(a) * f(m) <= 0 else (m, b)\n    return a\n",),
        {"def dichotomie(f, a, b, eps):\n    return (a + b) / 2\n":
         "Pour dichotomie(lambda x: x * x - 2, 0, 2, 1e-06), on attend 1.41421"},
    ),
    Kind(
        "imported names",
        declare("appliquer double", "from math import *\nfrom functools import reduce as plier\nfrom fractions import Fraction\n"
                "def appliquer(f, *x):\n    return f(*x)\ndef double(x):\n    return 2 * x\n",
                "appliquer(cos, 0)", "appliquer(lambda x: cos(x) + np.sin(x) + double(x), 0)", "appliquer(np.floor, 2.5)",
                "appliquer(plier, max, [3, 5, 4])", "appliquer(float, Fraction(1, 4))", "math.floor(appliquer(abs, -2.5))",
                tirages="x = reel(0, 1)", appel="appliquer(lambda t: exp(-t), x)"),
        ("def appliquer(f, *x):\n    if len(x) == 1:\n        return f(x[0])\n    return f(*x)\ndouble = lambda x: x + x\n",),
        {"def appliquer(f, *x):\n    return x[0]\ndef double(x):\n    return 2 * x\n":
         "Pour appliquer(cos, 0), on attend 1.0 et appliquer renvoie 0."},
    ),
    Kind(
        "unordered list",
        declare("diviseurs", "def diviseurs(n):\n    return [d for d in range(1, n + 1) if n % d == 0]\n", "diviseurs(6)",
                ordre="non"),
        ("def diviseurs(n):\n    return [d for d in range(n, 0, -1) if n % d == 0]\n",),
        {"def diviseurs(n):\n    return [d for d in range(1, n) if n % d == 0]\n": "Il manque l’élément 6."},
    ),
    Kind(
        "permutation",
        declare("melange", "def melange(t):\n    return t[::-1]\n", "melange([1, 2, 2])", ordre="non"),
        ("def melange(t):\n    return t\n",),
        {"def melange(t):\n    return list(set(t))\n": "Il manque l’élément 2."},
    ),
    Kind(
        "matrix",
        declare("transposee", "import numpy as np\ndef transposee(m):\n    return m.T\n", "transposee(np.array([[1.0, 2.0]]))",
                tirages="n = entier(1, 3); m = tableau((n, 2), -5, 5)", appel="transposee(m)"),
        ("def transposee(m):\n    return [list(c) for c in zip(*m)]\n",),
        {"def transposee(m):\n    return m\n": "élément"},
    ),
    Kind(
        "complex",
        declare("racines", "def racines(b, c):\n    d = (b * b - 4 * c) ** 0.5\n    return {(-b + d) / 2, (-b - d) / 2}\n", "racines(0, 1)",
                "racines(-3, 2)"),
        ("import cmath\ndef racines(b, c):\n    d = cmath.sqrt(b * b - 4 * c)\n    return {(-b - d) / 2, (-b + d) / 2}\n",),
        {"def racines(b, c):\n    return {1.0, 2.0}\n": "Il manque les éléments"},
    ),
    Kind(
        "several functions",
        declare("double quadruple", "def double(x):\n    return 2 * x\ndef quadruple(x):\n    return double(double(x))\n", "double(3)",
                "quadruple(2)"),
        ("def double(x):\n    return x + x\ndef quadruple(x):\n    return 4 * x\n",),
        {"def double(x):\n    return 2 * x\ndef quadruple(x):\n    return 2 * double(1)\n": "Pour quadruple(2), on attend 8"},
    ),
    Kind(
        "state between calls",
        declare("compteur", "n = 0\ndef compteur():\n    global n\n    n += 1\n    return n\n", "a = compteur(); b = compteur(); compteur()"),
        ("import itertools\n_c = itertools.count(1)\ndef compteur():\n    return next(_c)\n",),
        {"def compteur():\n    return 1\n": "compteur() doit donner 3 et donne 1"},
    ),
    Kind(
        "time limit",
        declare("fib", "def fib(n):\n    a, b = 0, 1\n    for _ in range(n):\n        a, b = b, a + b\n    return a\n", "fib(10)", "fib(60)"),
        ("from functools import cache\n@cache\ndef fib(n):\n    return n if n < 2 else fib(n - 1) + fib(n - 2)\n",),
        {"def fib(n):\n    return n if n < 2 else fib(n - 1) + fib(n - 2)\n": "la limite"},
    ),
    Kind(
        "plot as data",
        declare("courbe", "import numpy as np\ndef courbe(n):\n    x = np.linspace(0, 1, n)\n    return x, x ** 2\n", "courbe(3)"),
        ("def courbe(n):\n    x = [k / (n - 1) for k in range(n)]\n    return [x, [v * v for v in x]]\n",),
        {"import numpy as np\ndef courbe(n):\n    x = np.linspace(0, 1, n)\n    return x, x\n": "[1][1]"},
    ),
    Kind(
        "default argument",
        declare("puissance", "def puissance(x, n=2):\n    return x ** n\n", "puissance(3)", "puissance(3, n=3)", "puissance(2, 5)"),
        ("import math\ndef puissance(x, n=2):\n    return math.prod([x] * n)\n",),
        {"def puissance(x, n=3):\n    return x ** n\n": "Pour puissance(3), on attend 9 et puissance renvoie 27."},
    ),
)  # fmt: skip
