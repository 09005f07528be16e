def corriger(poses, delta):
    return poses + delta
