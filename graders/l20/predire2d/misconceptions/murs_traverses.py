CARTE = np.pad(np.ones((H, W), dtype=bool), 1)
