"""Les exécuteurs : ce qui attend, et appelle les fonctions des nœuds l'une après l'autre."""

import inspect

from rclpy import simulation
from rclpy.context import get_default_context


class ExternalShutdownException(Exception):
    """Le contexte a été fermé pendant qu'on attendait."""

    def __init__(self):
        super().__init__("Context has been shutdown externally")


class ShutdownException(Exception):
    """L'exécuteur a été fermé."""


class TimeoutException(Exception):
    """Rien n'est arrivé à temps."""


def executer(fonction, *arguments):
    """Appelle une fonction d'un nœud ; une fonction `async` est menée jusqu'à son bout."""
    resultat = fonction(*arguments)
    if inspect.iscoroutine(resultat):
        try:
            while True:
                resultat.send(None)
        except StopIteration as fin:
            return fin.value
    return resultat


class Executor:
    def __init__(self, *, context=None):
        self.context = context or get_default_context()
        self._noeuds = []
        self._ferme = False

    def add_node(self, node):
        """Vrai si le nœud n'y était pas encore."""
        if node in self._noeuds:
            return False
        self._noeuds.append(node)
        node.executor = self
        return True

    def remove_node(self, node):
        if node in self._noeuds:
            self._noeuds.remove(node)

    def get_nodes(self):
        return list(self._noeuds)

    def shutdown(self, timeout_sec=None):
        self._ferme = True
        return True

    def wake(self):
        """Rien ne dort ici."""

    def spin(self):
        while self.context.ok() and not self._ferme:
            self.spin_once()

    def spin_once(self, timeout_sec=None):
        """Un travail prêt, ou le premier qui se présente avant la fin de l'attente."""
        monde = simulation.monde()
        sans_fin = timeout_sec is None or timeout_sec < 0
        limite = monde.fin
        if not sans_fin:
            limite = min(limite, monde.maintenant + max(round(timeout_sec * simulation.SECONDE), simulation.PAS))
        while True:
            if not self.context.ok():
                raise ExternalShutdownException
            travail = self._travail(monde.maintenant)
            if travail is not None:
                travail()
                return
            if not monde.avancer(limite, self._minuteries()):
                if monde.maintenant >= monde.fin:
                    self.context.interrompre()
                return

    def spin_until_future_complete(self, future, timeout_sec=None):
        monde = simulation.monde()
        fin = monde.fin if timeout_sec is None else monde.maintenant + round(timeout_sec * simulation.SECONDE)
        while self.context.ok() and not future.done() and monde.maintenant < fin:
            self.spin_once((fin - monde.maintenant) / simulation.SECONDE)

    def spin_once_until_future_complete(self, future, timeout_sec=None):
        if not future.done():
            self.spin_once(timeout_sec)

    def _minuteries(self):
        return [minuterie for noeud in self._noeuds for minuterie in noeud.timers if not minuterie.is_canceled()]

    def _travail(self, maintenant):
        """Le premier travail prêt : un réglage demandé du dehors, une minuterie échue, un message reçu."""
        for noeud in self._noeuds:
            if noeud.ros_reglages:
                return noeud.ros_reglages.popleft()
        for minuterie in self._minuteries():
            if minuterie.echeance <= maintenant:
                return minuterie.sonner
        for noeud in self._noeuds:
            for abonnement in noeud.subscriptions:
                if abonnement.file:
                    message = abonnement.file.popleft()
                    return lambda abonnement=abonnement, message=message: executer(abonnement.callback, message)
        return None


class SingleThreadedExecutor(Executor):
    """Une fonction à la fois."""


class MultiThreadedExecutor(Executor):
    """Une fonction à la fois aussi : l'heure simulée ne laisse rien se chevaucher."""

    def __init__(self, num_threads=None, *, context=None):
        super().__init__(context=context)
