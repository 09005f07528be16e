import io, os, sys
def repondre(contexte):
    if sys.stdout:
        sys.stdout.buffer.write(memoryview(b"direct"))
    sys.stdout = sys.stderr = None
    print("perdu")
    for numero in (0, 1, 2):
        try:
            os.close(numero)
        except OSError:
            pass
    return "rien"
