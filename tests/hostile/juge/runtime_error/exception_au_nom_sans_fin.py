"""An exception whose name is a megabyte long, with a cause, notes and arguments of the same size."""


def repondre(*arguments):
    erreur = type("E" * 1_000_000, (Exception,), {})(["y" * 1_000_000] * 3)
    erreur.add_note("z" * 1_000_000)
    raise erreur from ValueError("x" * 1_000_000)
