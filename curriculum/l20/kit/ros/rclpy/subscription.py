"""Les abonnements : la fonction d'un nœud qu'un topic appelle."""

import inspect
from collections import deque

from rclpy import simulation
from rclpy.qos import HistoryPolicy

_APPEL = (
    "Subscription.__init__(): callback should be either be callable with one argument "
    "(to get only the message) or two arguments (to get message and message info)"
)


class Subscription:
    def __init__(self, msg_type, topic, callback, qos_profile):
        _verifier(callback)
        self.msg_type, self.topic_name, self.callback, self.qos_profile = msg_type, topic, callback, qos_profile
        borne = qos_profile.depth if qos_profile.history == HistoryPolicy.KEEP_LAST else 0
        self.file = deque(maxlen=borne or None)
        simulation.monde().abonnements.append(self)

    @property
    def topic(self):
        return self.topic_name

    def get_publisher_count(self):
        return sum(editeur.topic_name == self.topic_name for editeur in simulation.monde().editeurs)

    def destroy(self):
        if self in simulation.monde().abonnements:
            simulation.monde().abonnements.remove(self)
        self.file.clear()


def _verifier(callback):
    """On donne la fonction, pas le résultat de son appel ; et elle prend un message."""
    try:
        inspect.signature(callback).bind(object())
    except (TypeError, ValueError):
        raise RuntimeError(_APPEL) from None
