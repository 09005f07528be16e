"""Petits outils de rclpy."""

from rclpy.context import get_default_context


def ok(*, context=None):
    """Vrai de `rclpy.init()` à `rclpy.shutdown()`, ou jusqu'à Ctrl-C."""
    return (context or get_default_context()).ok()


def shutdown(*, context=None):
    (context or get_default_context()).shutdown()


def try_shutdown(*, context=None, uninstall_handlers=None):
    """Comme `shutdown`, sans se plaindre si c'est déjà fait."""
    (context or get_default_context()).try_shutdown()


def get_rmw_implementation_identifier():
    return "rmw_simule"
