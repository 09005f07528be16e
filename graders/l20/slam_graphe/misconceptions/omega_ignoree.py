_lineariser_pese = lineariser


def lineariser(poses, aretes):
    e, J, W = _lineariser_pese(poses, aretes)
    return e, J, np.eye(len(e))
