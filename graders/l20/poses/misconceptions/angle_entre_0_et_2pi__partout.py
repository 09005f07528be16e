def ramener(angle):
    return angle % (2 * np.pi)
