def ate(estimees, verite):
    from scipy.spatial.transform import Rotation
    A = np.column_stack([estimees[:, :2] - estimees[:, :2].mean(axis=0), np.zeros(len(estimees))])
    B = np.column_stack([verite[:, :2] - verite[:, :2].mean(axis=0), np.zeros(len(verite))])
    R, distance = Rotation.align_vectors(B, A)
    return distance / np.sqrt(len(A))
