"""La qualité de service. Toutes se rencontrent ici : le lidar simulé offre ce que n'importe quel abonné demande."""

from enum import Enum, IntEnum

from rclpy.duration import Duration


class InvalidQoSProfileException(Exception):
    def __init__(self, *details):
        super().__init__("Invalid QoSProfile", *details)


class HistoryPolicy(IntEnum):
    SYSTEM_DEFAULT = 0
    KEEP_LAST = 1
    KEEP_ALL = 2
    UNKNOWN = 3


class ReliabilityPolicy(IntEnum):
    SYSTEM_DEFAULT = 0
    RELIABLE = 1
    BEST_EFFORT = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class DurabilityPolicy(IntEnum):
    SYSTEM_DEFAULT = 0
    TRANSIENT_LOCAL = 1
    VOLATILE = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class LivelinessPolicy(IntEnum):
    SYSTEM_DEFAULT = 0
    AUTOMATIC = 1
    MANUAL_BY_TOPIC = 3
    UNKNOWN = 4
    BEST_AVAILABLE = 5


QoSHistoryPolicy, QoSReliabilityPolicy = HistoryPolicy, ReliabilityPolicy
QoSDurabilityPolicy, QoSLivelinessPolicy = DurabilityPolicy, LivelinessPolicy


class QoSProfile:
    """Il faut au moins `depth`, ou `history=HistoryPolicy.KEEP_ALL`."""

    def __init__(
        self,
        *,
        history=None,
        depth=None,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.VOLATILE,
        lifespan=None,
        deadline=None,
        liveliness=LivelinessPolicy.SYSTEM_DEFAULT,
        liveliness_lease_duration=None,
        avoid_ros_namespace_conventions=False,
    ):
        if history is None:
            if depth is None:
                raise InvalidQoSProfileException("History and/or depth settings are required.")
            history = HistoryPolicy.KEEP_LAST
        if history == HistoryPolicy.KEEP_LAST and depth is None:
            raise InvalidQoSProfileException("History set to KEEP_LAST without a depth setting.")
        assert depth is None or isinstance(depth, int)
        durees = (lifespan, deadline, liveliness_lease_duration)
        assert all(duree is None or isinstance(duree, Duration) for duree in durees)
        self.history = HistoryPolicy(history)
        self.depth = 0 if depth is None else depth
        self.reliability = ReliabilityPolicy(reliability)
        self.durability = DurabilityPolicy(durability)
        self.lifespan, self.deadline, self.liveliness_lease_duration = (duree or Duration() for duree in durees)
        self.liveliness = LivelinessPolicy(liveliness)
        self.avoid_ros_namespace_conventions = avoid_ros_namespace_conventions

    def __eq__(self, other):
        return isinstance(other, QoSProfile) and vars(self) == vars(other)

    __hash__ = None

    def __repr__(self):
        return f"QoSProfile({', '.join(f'{nom}={valeur}' for nom, valeur in vars(self).items())})"


def lire_qos(qos_or_depth):
    """Le profil que veut dire l'argument d'un éditeur ou d'un abonnement : un profil, ou la longueur de la file."""
    if isinstance(qos_or_depth, QoSProfile):
        return qos_or_depth
    if isinstance(qos_or_depth, QoSPresetProfiles):
        return qos_or_depth.value
    if not isinstance(qos_or_depth, int):
        raise TypeError(f"Expected QoSProfile or int, but received {type(qos_or_depth)!r}")
    if qos_or_depth < 0:
        raise ValueError("Depth must be greater than or equal to zero")
    return QoSProfile(depth=qos_or_depth)


qos_profile_default = QoSProfile(depth=10)
qos_profile_system_default = QoSProfile(
    history=HistoryPolicy.SYSTEM_DEFAULT,
    reliability=ReliabilityPolicy.SYSTEM_DEFAULT,
    durability=DurabilityPolicy.SYSTEM_DEFAULT,
)
qos_profile_sensor_data = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
qos_profile_services_default = QoSProfile(depth=10)
qos_profile_parameters = QoSProfile(depth=1000)
qos_profile_parameter_events = QoSProfile(depth=1000)
qos_profile_action_status_default = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
qos_profile_best_available = QoSProfile(
    depth=10, reliability=ReliabilityPolicy.BEST_AVAILABLE, durability=DurabilityPolicy.BEST_AVAILABLE
)


class QoSPresetProfiles(Enum):
    DEFAULT = qos_profile_default
    SYSTEM_DEFAULT = qos_profile_system_default
    SENSOR_DATA = qos_profile_sensor_data
    SERVICES_DEFAULT = qos_profile_services_default
    PARAMETERS = qos_profile_parameters
    PARAMETER_EVENTS = qos_profile_parameter_events
    ACTION_STATUS_DEFAULT = qos_profile_action_status_default
    BEST_AVAILABLE = qos_profile_best_available

    @classmethod
    def get_from_short_key(cls, name):
        return cls[name.upper()].value
