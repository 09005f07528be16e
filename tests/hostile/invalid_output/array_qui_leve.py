class Tableau:
    def __array__(self, dtype=None, copy=None):
        raise ValueError("non")
def repondre(contexte):
    return Tableau()
