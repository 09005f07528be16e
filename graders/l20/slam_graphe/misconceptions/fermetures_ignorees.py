_lineariser_tout = lineariser


def lineariser(poses, aretes):
    return _lineariser_tout(poses, [a for a in aretes if abs(a[1] - a[0]) == 1])
