def suivre():
    tout = []
    while True:
        tout.append(bytearray(1 << 24))
