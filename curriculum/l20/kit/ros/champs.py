"""Le moule des messages : des champs typés, qui refusent ce que ROS 2 refuse, avec ses mots.

Les paquets de messages (`sensor_msgs`, `geometry_msgs`…) ne sont que des listes de champs, dans leur fichier `msg.py`.
Dans ROS 2, ces classes sont engendrées à partir de fichiers `.msg` ; celles-ci se comportent comme elles.
"""

import array
import math
import struct
from collections import UserList
from collections.abc import Sequence, Set

PLUS_GRAND_FLOAT32 = 3.402823466e38


class Genre:
    """Un type de champ : sa valeur par défaut, ce qu'il accepte, ce qu'il devient en passant par le réseau."""

    nom_ros = ""

    def defaut(self):
        raise NotImplementedError

    def accepter(self, champ, valeur):
        raise NotImplementedError

    def transporter(self, valeur):
        return valeur


class Flottant(Genre):
    """`float64` ou `float32`. Un entier est refusé : 0 n'est pas 0.0."""

    def __init__(self, bits):
        self.bits = bits
        self.nom_ros = "double" if bits == 64 else "float"

    def defaut(self):
        return 0.0

    def accepter(self, champ, valeur):
        assert isinstance(valeur, float), f"The '{champ}' field must be of type 'float'"
        trop_grand = self.bits == 32 and not math.isinf(valeur) and abs(valeur) > PLUS_GRAND_FLOAT32
        assert not trop_grand, f"The '{champ}' field must be a float in [-3.402823466e+38, 3.402823466e+38]"
        return valeur

    def transporter(self, valeur):
        return struct.unpack("f", struct.pack("f", valeur))[0] if self.bits == 32 else valeur


class Entier(Genre):
    def __init__(self, bits, *, signe=True):
        self.bas, self.haut = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if signe else (0, 2**bits - 1)
        self.sorte = "an integer" if signe else "an unsigned integer"
        self.nom_ros = f"{'' if signe else 'u'}int{bits}"

    def defaut(self):
        return 0

    def accepter(self, champ, valeur):
        assert isinstance(valeur, int), f"The '{champ}' field must be of type 'int'"
        assert self.bas <= valeur <= self.haut, f"The '{champ}' field must be {self.sorte} in [{self.bas}, {self.haut}]"
        return valeur


class Simple(Genre):
    """Un booléen ou un texte."""

    def __init__(self, type_python, nom_ros):
        self.type_python, self.nom_ros = type_python, nom_ros

    def defaut(self):
        return self.type_python()

    def accepter(self, champ, valeur):
        nom = self.type_python.__name__
        assert isinstance(valeur, self.type_python), f"The '{champ}' field must be of type '{nom}'"
        return valeur


class Tableau(Genre):
    """Une suite de nombres de longueur libre, gardée dans un `array.array` : « f » pour `float32[]`."""

    def __init__(self, code, nom_ros, type_python=float):
        self.code, self.nom_ros, self.type_python = code, f"sequence<{nom_ros}>", type_python

    def defaut(self):
        return array.array(self.code)

    def accepter(self, champ, valeur):
        if isinstance(valeur, array.array):
            message = f"The '{champ}' array.array() must have the type code of '{self.code}'"
            assert valeur.typecode == self.code, message
            return valeur
        nom = self.type_python.__name__
        message = f"The '{champ}' field must be a set or sequence and each value of type '{nom}'"
        assert _est_suite(valeur, self.type_python), message
        return array.array(self.code, valeur)

    def transporter(self, valeur):
        return valeur[:]


class Liste(Genre):
    """Une suite de textes, ou de messages d'un type."""

    def __init__(self, type_python, nom_ros=""):
        self.type_python = type_python
        self.nom_ros = f"sequence<{nom_ros or nom_de(type_python)}>"

    def defaut(self):
        return []

    def accepter(self, champ, valeur):
        nom = self.type_python.__name__
        message = f"The '{champ}' field must be a set or sequence and each value of type '{nom}'"
        assert _est_suite(valeur, self.type_python), message
        return valeur

    def transporter(self, valeur):
        return [element.transporter() if isinstance(element, Message) else element for element in valeur]


class Sous(Genre):
    """Un message dans un message."""

    def __init__(self, classe):
        self.classe, self.nom_ros = classe, nom_de(classe).replace("/msg/", "/")

    def defaut(self):
        return self.classe()

    def accepter(self, champ, valeur):
        nom = self.classe.__name__
        assert isinstance(valeur, self.classe), f"The '{champ}' field must be a sub message of type '{nom}'"
        return valeur

    def transporter(self, valeur):
        return valeur.transporter()


DOUBLE, FLOAT = Flottant(64), Flottant(32)
BOOLEEN, TEXTE = Simple(bool, "boolean"), Simple(str, "string")
INT32, INT64, UINT8, UINT32, UINT64 = Entier(32), Entier(64), *(Entier(n, signe=False) for n in (8, 32, 64))


def _est_suite(valeur, type_python):
    suite = isinstance(valeur, (Sequence, Set, UserList)) and not isinstance(valeur, str)
    return suite and all(isinstance(v, type_python) for v in valeur)


def nom_de(classe):
    """Le nom ROS d'un type de message, comme « geometry_msgs/msg/Twist »."""
    return f"{classe.__module__.replace('.', '/')}/{classe.__name__}"


#: Les types de messages qui existent, par leur nom ROS.
TYPES = {}


class Message:
    """Un message : on donne ses champs par leur nom, au constructeur ou ensuite.

    `champs` dit le type de chacun ; une classe de message y vaut un message dans le message.
    """

    champs = {}

    def __init_subclass__(cls):
        genres = cls.__dict__.get("champs", {})
        cls.champs = {nom: genre if isinstance(genre, Genre) else Sous(genre) for nom, genre in genres.items()}
        TYPES.setdefault(nom_de(cls), cls)

    def __init__(self, **valeurs):
        inconnus = sorted(valeurs.keys() - self.champs.keys())
        assert not inconnus, f"Invalid arguments passed to constructor: {', '.join(inconnus)}"
        self.__dict__.update({nom: genre.defaut() for nom, genre in self.champs.items() if nom not in valeurs})
        for nom, valeur in valeurs.items():
            setattr(self, nom, valeur)

    def __setattr__(self, nom, valeur):
        if nom not in self.champs:
            raise AttributeError(f"'{type(self).__name__}' object has no attribute '{nom}'")
        object.__setattr__(self, nom, self.champs[nom].accepter(nom, valeur))

    def __eq__(self, autre):
        return isinstance(autre, type(self)) and all(getattr(self, nom) == getattr(autre, nom) for nom in self.champs)

    __hash__ = None

    def __repr__(self):
        valeurs = ", ".join(f"{nom}={getattr(self, nom)!r}" for nom in self.champs)
        return f"{type(self).__module__}.{type(self).__name__}({valeurs})"

    def transporter(self):
        """Le message tel qu'il arrive chez un autre nœud : une copie, dont les `float32` sont arrondis."""
        arrive = object.__new__(type(self))
        ici = self.__dict__
        arrive.__dict__.update({nom: genre.transporter(ici[nom]) for nom, genre in self.champs.items()})
        return arrive

    @classmethod
    def get_fields_and_field_types(cls):
        return {nom: genre.nom_ros for nom, genre in cls.champs.items()}
