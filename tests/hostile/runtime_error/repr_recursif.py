class Miroir:
    def __repr__(self):
        return repr([self])
    __str__ = __format__ = __repr__
def repondre(contexte):
    return f"{Miroir()}"
