"""Les minuteries : une fonction appelée à intervalles réguliers de l'heure simulée."""

from rclpy import simulation
from rclpy.executors import executer


class Timer:
    def __init__(self, callback, period_ns, *, autostart=True):
        self.callback = callback
        self._periode = max(period_ns, simulation.PAS)
        self._annulee = not autostart
        self.echeance = simulation.monde().maintenant + self._periode

    @property
    def timer_period_ns(self):
        return self._periode

    def sonner(self):
        """Appelle la fonction ; les échéances manquées ne sont pas rattrapées."""
        maintenant = simulation.monde().maintenant
        self.echeance += self._periode * max(1, (maintenant - self.echeance) // self._periode + 1)
        executer(self.callback)

    def cancel(self):
        self._annulee = True

    def is_canceled(self):
        return self._annulee

    def reset(self):
        self._annulee = False
        self.echeance = simulation.monde().maintenant + self._periode

    def is_ready(self):
        return not self._annulee and self.echeance <= simulation.monde().maintenant

    def time_since_last_call(self):
        return self._periode - self.time_until_next_call()

    def time_until_next_call(self):
        return max(0, self.echeance - simulation.monde().maintenant)

    def destroy(self):
        self._annulee = True
