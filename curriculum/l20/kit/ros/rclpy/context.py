"""Le contexte : ce que `rclpy.init()` ouvre et que `rclpy.shutdown()` ferme."""


class Context:
    def __init__(self):
        self._ouvert = False
        self._interrompu = False
        self._a_la_fin = []

    def init(self, args=None, *, initialize_logging=True, domain_id=None):
        if self._ouvert:
            raise RuntimeError("Context.init() must only be called once")
        self._ouvert, self._interrompu = True, False

    def ok(self):
        return self._ouvert

    def on_shutdown(self, callback):
        self._a_la_fin.append(callback)

    def shutdown(self):
        """Comme dans ROS 2, on ne ferme pas deux fois ; mais qui a reçu Ctrl-C peut encore fermer derrière lui."""
        if self._interrompu:
            self._interrompu = False
        elif not self._ouvert:
            raise RuntimeError("Context must be initialized before it can be shutdown")
        self._fermer()

    def try_shutdown(self):
        self._fermer()

    def destroy(self):
        self._fermer()

    def interrompre(self):
        """Ctrl-C : il ne se passera plus rien."""
        self._fermer()
        self._interrompu = True

    def _fermer(self):
        if self._ouvert:
            self._ouvert = False
            while self._a_la_fin:
                self._a_la_fin.pop()()

    def __enter__(self):
        self.init()
        return self

    def __exit__(self, *_):
        self.try_shutdown()


_PAR_DEFAUT = Context()


def get_default_context(*, shutting_down=False):
    return _PAR_DEFAUT
