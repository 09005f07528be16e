"""Les éditeurs : ce par quoi un nœud publie."""

from rclpy import simulation


class Publisher:
    def __init__(self, msg_type, topic, qos_profile):
        self.msg_type, self.qos_profile = msg_type, qos_profile
        self._topic = topic
        self._ouvert = True
        simulation.monde().editeurs.append(self)

    @property
    def topic_name(self):
        return self._topic

    topic = topic_name

    def publish(self, msg):
        """Le message part tel qu'il est maintenant : le changer ensuite n'y change rien."""
        if not isinstance(msg, self.msg_type):
            raise TypeError(f"Expected {self.msg_type}, got {type(msg)}")
        if not self._ouvert:
            raise RuntimeError("cannot use Destroyable because destruction was requested")
        simulation.monde().entendre(self._topic, msg.transporter())

    def get_subscription_count(self):
        return sum(abonnement.topic_name == self._topic for abonnement in simulation.monde().abonnements)

    def assert_liveliness(self):
        """Rien à prouver ici."""

    def wait_for_all_acked(self, timeout=None):
        return True

    def destroy(self):
        self._ouvert = False
