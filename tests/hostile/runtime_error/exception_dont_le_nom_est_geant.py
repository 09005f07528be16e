def repondre(contexte):
    raise type("E" * 10**6, (Exception,), {"__str__": lambda self: 1 / 0, "__repr__": lambda self: 1 / 0})
