"""Vecteurs, poses, vitesses. Mètres, radians et secondes partout (REP 103)."""

from champs import DOUBLE, Message
from std_msgs.msg import Header


class Vector3(Message):
    champs = {"x": DOUBLE, "y": DOUBLE, "z": DOUBLE}


class Point(Message):
    champs = {"x": DOUBLE, "y": DOUBLE, "z": DOUBLE}


class Quaternion(Message):
    champs = {"x": DOUBLE, "y": DOUBLE, "z": DOUBLE, "w": DOUBLE}

    def __init__(self, **valeurs):
        super().__init__(**{"w": 1.0, **valeurs})


class Pose(Message):
    champs = {"position": Point, "orientation": Quaternion}


class PoseStamped(Message):
    champs = {"header": Header, "pose": Pose}


class Twist(Message):
    """Une vitesse : `linear.x` vers l'avant, `angular.z` autour de la verticale. Un Twist() neuf est l'arrêt."""

    champs = {"linear": Vector3, "angular": Vector3}


class TwistStamped(Message):
    champs = {"header": Header, "twist": Twist}
