# Un programme juste, écrit autrement : il doit avoir 20. Plus il y en a, moins on refuse d'honnêtes programmes.
def __SLUG__(depart, arrivee, fraction):
    return (1 - fraction) * depart + fraction * arrivee
