ATTENDUS = lidar_lot(np.column_stack([X, Y, np.zeros(len(X))]), 4)
