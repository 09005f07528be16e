"""Logins: folded for comparison, and written in one alphabet, so that no two of them look alike."""

from __future__ import annotations

import unicodedata

from server.text.lines import describe_forbidden_character, normalise_line

LOGIN_LENGTH = range(2, 255)
LENGTH_PROBLEM = "L’identifiant compte de 2 à 254 caractères, sans espace."

LIGATURES = str.maketrans({"œ": "oe", "æ": "ae"})  # the others are compatibility forms
#: Scripts that are written together, and none of whose letters looks like a Latin one.
EAST_ASIAN = frozenset({"CJK", "HIRAGANA", "KATAKANA", "KATAKANA-HIRAGANA", "HANGUL", "BOPOMOFO"})
SCRIPTS = {
    "LATIN": "latines", "CYRILLIC": "cyrilliques", "GREEK": "grecques", "ARMENIAN": "arméniennes",
    "CHEROKEE": "cherokees", "ARABIC": "arabes", "HEBREW": "hébraïques", "COPTIC": "coptes", "GEORGIAN": "géorgiennes",
}  # fmt: skip
MIXED = (
    "L’identifiant « {login} » mélange des lettres {first} et {second} (« {letter} », au rang {place}) : il ressemble "
    "à un autre. Retapez-le dans un seul alphabet."
)
#: Lower-case Cyrillic and Greek letters, and the Latin ones that they look like.
LOOK_ALIKES = dict(zip("асеорхуіјѕһԁԛԝѵмкнтвгοανρυκιϲϳ", "aceopxyijshdqwvmkhtbroavpukicj", strict=True))


def normalise_login(text: str) -> str:
    """Fold invisible characters, compatibility forms (full width, ligatures) and case: equal logins are one login."""
    login = normalise_line(text)
    for _ in range(4):  # folding case may compose, and composing may leave a capital
        folded = unicodedata.normalize("NFKC", login).casefold().translate(LIGATURES)
        folded = normalise_line(folded)
        if folded == login:
            break
        login = folded
    return login


def unfolded_login(text: str) -> str:
    """Return a login as it was stored before forms were folded; accounts whose folded login was taken keep it."""
    return text.strip().casefold()


def is_valid_login(login: str) -> bool:
    """Whether an account may have this login; those made before alphabets were checked included."""
    return len(login) in LOGIN_LENGTH and login.isprintable() and " " not in login


def login_problem(login: str) -> str:
    """Return why a new account cannot have this normalised login, or an empty text."""
    if not is_valid_login(login):
        unwritable = describe_forbidden_character(login)
        return f"Dans l’identifiant, {unwritable}." if unwritable else LENGTH_PROBLEM
    return next(filter(None, (_mixed_scripts_problem(login, part) for part in login.split("@"))), "")


def find_latin_look_alike(login: str) -> str:
    """Return the Latin login that this one looks like, letter by letter; the login itself where it looks like none."""
    letters = [sign for sign in login.partition("@")[0] if sign.isalpha()]
    if not letters or not all(sign in LOOK_ALIKES for sign in letters):
        return login
    return "".join(LOOK_ALIKES.get(sign, sign) for sign in login)


def _mixed_scripts_problem(login: str, part: str) -> str:
    first = ""
    for sign in part:
        script = _script_of_letter(sign)
        if not script or script in EAST_ASIAN:
            continue
        if first and script != first:
            place = login.index(sign) + 1
            return MIXED.format(
                login=login[:60],
                first=_script_in_french(first),
                second=_script_in_french(script),
                letter=sign,
                place=place,
            )
        first = first or script
    return ""


def _script_of_letter(sign: str) -> str:
    """Return the script of a letter as the first word of its Unicode name, or an empty text."""
    return unicodedata.name(sign, "").partition(" ")[0] if unicodedata.category(sign)[0] == "L" else ""


def _script_in_french(script: str) -> str:
    return SCRIPTS.get(script, f"d’un autre alphabet ({script.lower()})")
