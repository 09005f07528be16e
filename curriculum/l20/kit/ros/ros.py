"""La trousse des nœuds : ROS 2 simulé, et de quoi faire vivre un nœud dans un monde d'essai.

Votre programme importe `rclpy`, `sensor_msgs`, `geometry_msgs` et `std_msgs` comme sur un robot, et trouve aussi tout
ce que donne `l20`. Pour essayer un nœud chez vous, posez votre fichier à côté de celui-ci, puis par exemple :

    from ros import jouer

    proche = {"ranges": [5.0] * 18 + [0.2] + [5.0] * 17, "range_min": 0.05, "range_max": 10.0}
    evenement = {"t": 0.0, "topic": "/scan", "type": "sensor_msgs/msg/LaserScan", "message": proche, "fois": 3}
    print(jouer(ArretUrgence, {"duree": 1.0, "evenements": [evenement]}))

Sur une machine où ROS 2 est installé, rien de tout cela n'est utile : votre fichier y tourne tel quel.
"""

import geometry_msgs.msg  # noqa: F401
import l20
import numpy as np
import rclpy
import sensor_msgs.msg  # noqa: F401
import std_msgs.msg  # noqa: F401
from champs import TYPES, nom_de
from rclpy import simulation
from rclpy.context import get_default_context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

#: Au-delà, les messages publiés sur un topic ne sont plus écrits.
PLUS_DE_MESSAGES = 20_000


def configurer(noeuds=(), **monde):
    """Les noms de `l20` ; une classe nommée dans `noeuds` est jouée au lieu d'être appelée."""
    simulation.changer(simulation.Monde())
    get_default_context().try_shutdown()
    noms = l20.configurer(**monde)
    vars(l20).update(noms)
    return {**noms, "__drivers__": dict.fromkeys(noeuds, jouer)}


def jouer(fabrique, scenario):
    """Fait vivre le nœud que renvoie `fabrique()`, et rend compte de ce qu'il a fait.

    `scenario` : sa `duree` en secondes ; `parametres`, les valeurs données au lancement ; des `evenements`, chacun à
    l'instant `t` : un message (`topic`, `type`, `message`, répété `fois` fois à `periode` secondes d'intervalle), ou un
    réglage venu du dehors (`parametre`, `valeur`).
    """
    monde = simulation.Monde(round(scenario["duree"] * simulation.SECONDE))
    monde.parametres_donnes = dict(scenario.get("parametres", {}))
    simulation.changer(monde)
    contexte = get_default_context()
    contexte.try_shutdown()
    rclpy.init()
    cahier = _Cahier(monde)
    for evenement in scenario["evenements"]:
        _prevoir(monde, evenement, cahier)
    noeud = fabrique()
    if not isinstance(noeud, Node):
        raise TypeError("la classe doit hériter de rclpy.node.Node")
    cahier.noeud = noeud
    executeur = SingleThreadedExecutor()
    executeur.add_node(noeud)
    if not contexte.ok():  # le nœud a tourné dès sa construction
        return cahier.rendre()
    executeur.spin()
    return cahier.rendre()


def _prevoir(monde, evenement, cahier):
    debut = simulation.DEBUT + round(evenement["t"] * simulation.SECONDE)
    if "parametre" in evenement:
        monde.prevoir(debut, lambda: cahier.regler(evenement["parametre"], evenement["valeur"]))
        return
    message = remplir(TYPES[evenement["type"]](), evenement["message"])
    for k in range(evenement.get("fois", 1)):
        instant = debut + round(k * evenement.get("periode", 0.1) * simulation.SECONDE)
        monde.prevoir(instant, lambda: monde.publier(evenement["topic"], dater(message)))


def remplir(message, valeurs):
    """Donne ces valeurs aux champs ; celles d'un message dans le message sont dans un dictionnaire."""
    for nom, valeur in valeurs.items():
        setattr(message, nom, _valeur(getattr(message, nom), valeur))
    return message


def _valeur(ancienne, valeur):
    if isinstance(valeur, dict):
        return remplir(ancienne, valeur)
    return valeur.tolist() if isinstance(valeur, np.ndarray) else valeur


def dater(message):
    """Une mesure porte la date où elle est prise, et le repère du capteur."""
    if "header" in message.champs:
        if not message.header.frame_id:
            message.header.frame_id = "laser"
        ecoulees, reste = divmod(simulation.monde().maintenant, simulation.SECONDE)
        message.header.stamp.sec, message.header.stamp.nanosec = ecoulees, reste
    return message


class _Cahier:
    """Ce qui est écrit de la vie d'un nœud : ce qu'il publie, ce qu'il écoute, comment il a répondu aux réglages."""

    def __init__(self, monde):
        self.noeud = None
        self._monde, self._messages, self._reponses = monde, {}, []
        monde.ecoutes.append(self._entendre)

    def _entendre(self, instant, topic, message):
        lignes = self._messages.setdefault((topic, nom_de(type(message))), [])
        if len(lignes) < PLUS_DE_MESSAGES:
            lignes.append((_secondes(instant), dict(_nombres(message))))

    def regler(self, nom, valeur):
        """Demande le réglage à tous les nœuds : un seul l'a déclaré."""
        for noeud in self._monde.noeuds:
            noeud.ros_demander(nom, valeur, lambda resultat: self._repondre(nom, resultat))

    def _repondre(self, nom, resultat):
        ligne = {"t": _secondes(self._monde.maintenant), "parametre": nom, "accepte": bool(resultat.successful)}
        self._reponses.append({**ligne, "raison": str(resultat.reason)[:200]})

    def rendre(self):
        """Des valeurs simples. `publications` : topic, type, instants (k,), noms et valeurs (k, m) des nombres."""
        publications = []
        for (topic, type_), lignes in self._messages.items():
            if topic == "/parameter_events":
                continue
            champs = list(lignes[0][1])
            valeurs = np.array([list(nombres.values()) for _, nombres in lignes if len(nombres) == len(champs)], float)
            instants = np.array([t for t, nombres in lignes if len(nombres) == len(champs)], float)
            publications.append({"topic": topic, "type": type_, "t": instants, "champs": champs, "valeurs": valeurs})
        return {
            "abonnements": [[abonne.topic_name, nom_de(abonne.msg_type)] for abonne in self._monde.abonnements],
            "editeurs": [
                [editeur.topic_name, nom_de(editeur.msg_type)]
                for noeud in self._monde.noeuds
                for editeur in noeud.publishers
            ],
            "publications": publications,
            "reglages": self._reponses,
        }


def _secondes(instant):
    return (instant - simulation.DEBUT) / simulation.SECONDE


def _nombres(message, avant=""):
    """Les nombres d'un message, sous des noms comme « linear.x »."""
    for nom in message.champs:
        valeur = getattr(message, nom)
        if hasattr(valeur, "champs"):
            yield from _nombres(valeur, f"{avant}{nom}.")
        elif isinstance(valeur, (bool, int, float)):
            yield avant + nom, float(valeur)
