"""Un double de rclpy, la bibliothèque Python de ROS 2, pour faire tourner un nœud sans robot ni ROS.

Les noms et les comportements sont ceux de ROS 2 partout où un nœud de ce cours peut les rencontrer : un fichier qui
tourne ici tourne là-bas. Deux différences. L'heure est simulée (voir `simulation.py`) ; et `spin` rend la main, comme
après Ctrl-C, quand il ne peut plus rien arriver.
"""

from rclpy.context import Context, get_default_context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from rclpy.utilities import get_rmw_implementation_identifier, ok, try_shutdown
from rclpy.utilities import shutdown as _shutdown

__all__ = [
    "Context",
    "Future",
    "Parameter",
    "create_node",
    "get_default_context",
    "get_global_executor",
    "get_rmw_implementation_identifier",
    "init",
    "ok",
    "shutdown",
    "spin",
    "spin_once",
    "spin_until_future_complete",
    "try_shutdown",
]


def init(args=None, *, context=None, domain_id=None, signal_handler_options=None):
    """À appeler avant de créer un nœud."""
    (context or get_default_context()).init(args, domain_id=domain_id)


def shutdown(*, context=None, uninstall_handlers=None):
    """Ferme ce que `init` a ouvert."""
    _shutdown(context=context)


def create_node(node_name, **options):
    return Node(node_name, **options)


def get_global_executor():
    """Un exécuteur neuf : ici rien ne reste d'un `spin` à l'autre."""
    return SingleThreadedExecutor()


def _avec(node, executor, attendre):
    executor = get_global_executor() if executor is None else executor
    ajoute = executor.add_node(node)
    try:
        attendre(executor)
    finally:
        if ajoute:
            executor.remove_node(node)


def spin(node, executor=None):
    """Donne la main à ROS, qui appelle les fonctions du nœud ; revient quand le contexte est fermé."""
    _avec(node, executor, lambda executeur: executeur.spin())


def spin_once(node, *, executor=None, timeout_sec=None):
    """Fait un seul travail, ou attend au plus `timeout_sec` secondes."""
    _avec(node, executor, lambda executeur: executeur.spin_once(timeout_sec=timeout_sec))


def spin_until_future_complete(node, future, executor=None, timeout_sec=None):
    _avec(node, executor, lambda executeur: executeur.spin_until_future_complete(future, timeout_sec))
