"""Le monde simulé où vivent les nœuds : l'heure, ce qui doit arriver, qui écoute quoi, ce qui a été dit.

Rien ici n'existe dans ROS 2 : c'est ce qui y tient lieu de réseau et d'horloge. L'heure n'avance que lorsqu'un nœud
attend (`spin`), et saute alors tout droit au prochain événement : une minute simulée ne dure rien.
"""

import heapq
import itertools

SECONDE = 1_000_000_000
#: Ce qui attend zéro seconde attend quand même un peu, ou l'heure n'avancerait jamais.
PAS = SECONDE // 1000
DEBUT = 1000 * SECONDE


class Monde:
    """Un monde neuf. `fin` : l'instant, en nanosecondes, où quelqu'un tape Ctrl-C."""

    def __init__(self, duree=0):
        self.maintenant = DEBUT
        self.fin = DEBUT + duree
        self.noeuds = []
        self.abonnements = []
        self.editeurs = []
        self.ecoutes = []
        self.parametres_donnes = {}
        self._agenda = []
        self._numeros = itertools.count()

    def prevoir(self, instant, action):
        """`action()` aura lieu à cet instant."""
        heapq.heappush(self._agenda, (instant, next(self._numeros), action))

    def publier(self, topic, message):
        """Dépose une copie du message chez chaque abonné au topic, s'il attend ce type."""
        for abonnement in list(self.abonnements):
            if abonnement.topic_name == topic and type(message) is abonnement.msg_type:
                abonnement.file.append(message.transporter())

    def entendre(self, topic, message):
        """Ce qu'un nœud publie : on l'écrit pour qui veut le lire, puis on le distribue."""
        for ecoute in self.ecoutes:
            ecoute(self.maintenant, topic, message)
        self.publier(topic, message)

    def avancer(self, limite, minuteries):
        """Va au prochain événement, s'il vient avant la limite ; dit s'il y en avait un."""
        instants = [minuterie.echeance for minuterie in minuteries]
        if self._agenda:
            instants.append(self._agenda[0][0])
        prochain = min(instants, default=None)
        if prochain is None or prochain > limite:
            self.maintenant = max(self.maintenant, limite)
            return False
        self.maintenant = max(self.maintenant, prochain)
        while self._agenda and self._agenda[0][0] <= self.maintenant:
            heapq.heappop(self._agenda)[2]()
        return True


class _Place:
    monde = Monde()


def monde():
    """Le monde d'à présent."""
    return _Place.monde


def changer(nouveau):
    """Un autre monde prend sa place."""
    _Place.monde = nouveau
