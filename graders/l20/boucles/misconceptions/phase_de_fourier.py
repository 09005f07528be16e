def signature(scan):
    return np.angle(np.fft.rfft(scan))
