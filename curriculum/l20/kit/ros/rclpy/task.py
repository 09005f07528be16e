"""Une réponse à venir."""


class Future:
    def __init__(self, *, executor=None):
        self._fait = self._annule = False
        self._resultat = self._erreur = None
        self._suites = []

    def done(self):
        return self._fait or self._annule

    def cancelled(self):
        return self._annule

    def cancel(self):
        self._annule = not self._fait

    def result(self):
        if self._erreur is not None:
            raise self._erreur
        return self._resultat

    def exception(self):
        return self._erreur

    def set_result(self, result):
        self._resultat, self._fait = result, True
        self._terminer()

    def set_exception(self, exception):
        self._erreur, self._fait = exception, True
        self._terminer()

    def add_done_callback(self, callback):
        if self.done():
            callback(self)
        else:
            self._suites.append(callback)

    def _terminer(self):
        for suite in self._suites:
            suite(self)
        self._suites = []
