"""Un nœud : ce dont hérite la classe que l'on écrit."""

import re
from collections import deque

from champs import Message
from rcl_interfaces.msg import ParameterEvent, SetParametersResult

from rclpy import simulation
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.clock import ROSClock
from rclpy.context import get_default_context
from rclpy.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidTopicNameException,
    NotInitializedException,
    ParameterNotDeclaredException,
)
from rclpy.logging import get_logger
from rclpy.parameter import Parameter
from rclpy.parametres import Parametres
from rclpy.publisher import Publisher
from rclpy.qos import lire_qos
from rclpy.subscription import Subscription
from rclpy.timer import Timer

__all__ = ["Node", "Parameter", "SetParametersResult"]

_NOM = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_TOPIC = re.compile(r"(~|~?/)?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
_LETTRES = "must not contain characters other than alphanumerics or '_', nor start with a number"


class Node(Parametres):
    """Ce qui n'est pas de ROS 2 commence par `ros_` ou `_ros_` : vos noms à vous restent libres."""

    def __init__(
        self,
        node_name,
        *,
        context=None,
        cli_args=None,
        namespace=None,
        use_global_arguments=True,
        enable_rosout=True,
        start_parameter_services=True,
        parameter_overrides=None,
        allow_undeclared_parameters=False,
        automatically_declare_parameters_from_overrides=False,
        enable_logger_service=False,
    ):
        contexte = context or get_default_context()
        if not contexte.ok():
            raise NotInitializedException("cannot create node")
        if not _NOM.fullmatch(node_name):
            raise InvalidNodeNameException(node_name, f"node name {_LETTRES}")
        espace = "/" + (namespace or "").strip("/")
        if espace != "/" and not _TOPIC.fullmatch(espace):
            raise InvalidNamespaceException(espace, f"namespace {_LETTRES}")
        self.context, self.executor = contexte, None
        self._ros_nom, self._ros_espace = node_name, espace
        self._ros_horloge = ROSClock()
        self._ros_journal = get_logger(self.get_fully_qualified_name()[1:].replace("/", "."))
        self._ros_editeurs, self._ros_abonnements, self._ros_minuteries = [], [], []
        self._ros_groupe = MutuallyExclusiveCallbackGroup()
        self.ros_reglages = deque()
        monde = simulation.monde()
        donnes = dict(monde.parametres_donnes) if use_global_arguments else {}
        donnes.update({parametre.name: parametre.value for parametre in parameter_overrides or ()})
        self._ros_preparer_parametres(donnes, allow_undeclared_parameters)
        self._ros_annonce_parametres = Publisher(ParameterEvent, "/parameter_events", lire_qos(1000))
        if automatically_declare_parameters_from_overrides:
            self.declare_parameters("", list(donnes.items()))
        monde.noeuds.append(self)

    def __getattr__(self, nom):
        if nom.startswith("_") and "_ros_nom" not in self.__dict__:
            message = f"'{type(self).__name__}' object has no attribute '{nom}'"
            raise AttributeError(f'{message} (super().__init__("…") a-t-il été appelé d\'abord ?)')
        raise AttributeError(f"'{type(self).__name__}' object has no attribute '{nom}'")

    def get_name(self):
        return self._ros_nom

    def get_namespace(self):
        return self._ros_espace

    def get_fully_qualified_name(self):
        return f"{self._ros_espace.rstrip('/')}/{self._ros_nom}"

    def get_logger(self):
        return self._ros_journal

    def get_clock(self):
        return self._ros_horloge

    @property
    def default_callback_group(self):
        return self._ros_groupe

    @property
    def publishers(self):
        return iter(self._ros_editeurs)

    @property
    def subscriptions(self):
        return iter(list(self._ros_abonnements))

    @property
    def timers(self):
        return iter(list(self._ros_minuteries))

    def create_publisher(self, msg_type, topic, qos_profile, *, callback_group=None, event_callbacks=None, **_):
        """Annonce que ce nœud publiera des messages de ce type sur ce topic."""
        editeur = Publisher(_type(msg_type), self.resolve_topic_name(topic), lire_qos(qos_profile))
        self._ros_editeurs.append(editeur)
        return editeur

    def create_subscription(
        self, msg_type, topic, callback, qos_profile, *, callback_group=None, event_callbacks=None, **_
    ):
        """Demande que `callback(message)` soit appelé à chaque message."""
        abonnement = Subscription(_type(msg_type), self.resolve_topic_name(topic), callback, lire_qos(qos_profile))
        self._ros_abonnements.append(abonnement)
        return abonnement

    def create_timer(self, timer_period_sec, callback, callback_group=None, clock=None, autostart=True):
        """Demande que `callback()` soit appelé toutes les `timer_period_sec` secondes."""
        minuterie = Timer(callback, round(float(timer_period_sec) * simulation.SECONDE), autostart=autostart)
        self._ros_minuteries.append(minuterie)
        return minuterie

    def resolve_topic_name(self, topic, *, only_expand=False):
        """Le nom complet : « scan » devient « /scan », « ~/scan » devient « /nom_du_nœud/scan »."""
        if not isinstance(topic, str):
            raise TypeError(f"topic must be a str, got {type(topic)}")
        if not _TOPIC.fullmatch(topic):
            raise InvalidTopicNameException(topic, f"topic name {_LETTRES}")
        if topic.startswith("/"):
            return topic
        if topic.startswith("~"):
            return self.get_fully_qualified_name() + topic[1:]
        return f"{self._ros_espace.rstrip('/')}/{topic}"

    def count_publishers(self, topic_name):
        complet = self.resolve_topic_name(topic_name)
        return sum(editeur.topic_name == complet for editeur in simulation.monde().editeurs)

    def count_subscribers(self, topic_name):
        complet = self.resolve_topic_name(topic_name)
        return sum(abonnement.topic_name == complet for abonnement in simulation.monde().abonnements)

    def destroy_publisher(self, publisher):
        return self._ros_retirer(self._ros_editeurs, publisher)

    def destroy_subscription(self, subscription):
        return self._ros_retirer(self._ros_abonnements, subscription)

    def destroy_timer(self, timer):
        return self._ros_retirer(self._ros_minuteries, timer)

    def destroy_node(self):
        for liste in (self._ros_editeurs, self._ros_abonnements, self._ros_minuteries):
            for element in list(liste):
                self._ros_retirer(liste, element)

    @staticmethod
    def _ros_retirer(liste, element):
        if element not in liste:
            return False
        liste.remove(element)
        element.destroy()
        return True

    def ros_demander(self, nom, valeur, repondre):
        """Ce que fait `ros2 param set` : le nœud change son paramètre quand vient son tour, et répond."""

        def regler():
            try:
                resultat = self.set_parameters_atomically([Parameter(nom, value=valeur)])
            except ParameterNotDeclaredException as erreur:
                resultat = SetParametersResult(successful=False, reason=str(erreur))
            repondre(resultat)

        self.ros_reglages.append(regler)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.destroy_node()


def _type(msg_type):
    """Un type de message : la classe elle-même, importée de `….msg`."""
    if not (isinstance(msg_type, type) and issubclass(msg_type, Message)):
        raise AttributeError(f"{msg_type!r} is not a message type")
    return msg_type
