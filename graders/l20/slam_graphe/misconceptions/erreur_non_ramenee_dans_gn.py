_lineariser_ramene = lineariser


def lineariser(poses, aretes):
    e, J, W = _lineariser_ramene(poses, aretes)
    for k, (i, j, z, _) in enumerate(aretes):
        e[3 * k + 2] = poses[j][2] - poses[i][2] - z[2]
    return e, J, W
