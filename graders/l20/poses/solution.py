def ramener(angle):
    """Ramène un angle (en radians) dans l'intervalle ]−π, π]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


def composer(a, b):
    """La pose b, donnée dans le repère de a, exprimée dans le repère du monde."""
    xa, ya, ta = a
    xb, yb, tb = b
    # On tourne le vecteur (xb, yb) du cap de a, puis on l'ajoute à la position de a.
    x = xa + xb * np.cos(ta) - yb * np.sin(ta)
    y = ya + xb * np.sin(ta) + yb * np.cos(ta)
    return np.array([x, y, ramener(ta + tb)])


def inverse(a):
    """La pose du monde vue depuis a : c'est elle qui, composée avec a, ramène à l'origine."""
    x, y, t = a
    # On annule la translation, puis on la regarde dans le repère tourné de −t.
    return np.array([-x * np.cos(t) - y * np.sin(t), x * np.sin(t) - y * np.cos(t), ramener(-t)])


def relatif(a, b):
    """La pose b vue depuis a, les deux étant données dans le repère du monde."""
    return composer(inverse(a), b)
