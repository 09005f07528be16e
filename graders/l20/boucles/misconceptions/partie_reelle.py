def signature(scan):
    return np.fft.fft(scan).real
