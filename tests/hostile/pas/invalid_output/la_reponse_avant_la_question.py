import os
def suivre():
    for fd in range(3, 300):
        try:
            os.write(fd, bytes(13))
        except OSError:
            pass
    return "rien"
