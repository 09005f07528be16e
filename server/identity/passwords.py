"""Refuse common passwords, by NIST SP 800-63B, section 5.1.1.2.

Length matters: no mixture of characters is required. A strength estimator (zxcvbn) takes seconds on adversarial input;
guesses are rate limited anyway, so that a short list is enough.
"""

import re

LENGTH = range(8, 1025)
MIN_DISTINCT = 4
RUNS = ("abcdefghijklmnopqrstuvwxyz", "01234567890", "azertyuiopqsdfghjklmwxcvbn", "qwertyuiopasdfghjklzxcvbnm")
AROUND = re.compile(r"^[\W\d_]+|[\W\d_]+$")

#: The words that common passwords are made of, with digits or signs around them or not.
WORDS = """
abc abcd abcde abcdef abc123 admin administrateur administrator alexandre amour amsterdam anthony arsenal azerty
azertyuiop azqswx balise barcelona baseball basketball batman benjamin bienvenue bigbang bisous bonjour bordeaux
butterfly caramel camille celtic changeme charlotte cheval chocolat chocolate chouchou chouette cocacola coucou
computer computers daniel default dolphin doudou doudoune dragon ecole elephant elodie eleve eleves etudiant
football france francois freedom gabriel gangster guillaume hello hunter iloveyou internet isabelle jennifer jeremy
jessica jesus jetaime jonathan jordan julien killer kevin letmein liberte liverpool login loulou louloute lovely
lycee machine maison maman mamanpapa marine marseille martin master mathieu maximilien michael michelle minecraft
monkey montpellier mustang mylove naruto nathalie nicolas nintendo nirvana olivier ordinateur papamaman paris
parissaintgermain pass passe passw passwd password passwords passwort patate patrick pikachu pokemon
pompier porsche portugal prepa princess princesse prof professeur qazwsx qazwsxedc qsdfghjklm qwer qwerty qwertyuiop
rencontre robot romain rugby samsung scoubidou sebastien secret secrets shadow shadows skyline snoopy soleil sophie
spiderman starwars stephane stephanie sunshine superman sweetheart taekwondo thebest thomas tinkerbell titeuf toto
toulouse trustno unicorn valentin valerie vanessa vincent virginie voiture welcome whatever william motdepasse
monmotdepasse motpasse mdp nouveau nouveaumotdepasse changezmoi test testtest
"""
COMMON = frozenset(WORDS.split())

TOO_SHORT = f"Le mot de passe compte au moins {LENGTH.start} caractères."
TOO_LONG = "Le mot de passe est trop long."
BLANK = "Un mot de passe fait d’espaces seulement se devine tout de suite."
SAME = "Le mot de passe ne peut pas être l’identifiant ni le nom : c’est ce que l’on essaie en premier."
TOO_COMMON = (
    "Ce mot de passe est parmi ceux que l’on essaie en premier. Choisissez par exemple quelques mots sans rapport "
    "entre eux."
)


def password_problem(password: str, *, login: str, name: str) -> str:
    """Return why a password is refused, or an empty text. `login` is normalised."""
    if len(password) < LENGTH.start:
        return TOO_SHORT
    if len(password) >= LENGTH.stop:
        return TOO_LONG
    if not password.strip():
        return BLANK
    if _fold_password(password) in {
        _fold_password(login),
        _fold_password(login.partition("@")[0]),
        _fold_password(name),
    } - {""}:
        return SAME
    return TOO_COMMON if _is_common_password(password.casefold()) else ""


def _fold_password(text: str) -> str:
    """Fold case, spaces and punctuation."""
    return re.sub(r"[\W_]+", "", text.casefold())


def _is_common_password(password: str) -> bool:
    core = AROUND.sub("", password)
    return (
        len(set(password)) < MIN_DISTINCT
        or _is_keyboard_run(_shortest_repeated_part(password))
        or _fold_password(core) in COMMON
        or _fold_password(password) in COMMON
        or _shortest_repeated_part(_fold_password(password)) in COMMON
    )


def _shortest_repeated_part(text: str) -> str:
    """Return the shortest text of which this is a repetition."""
    return text[: (text + text).find(text, 1)] if text else text


def _is_keyboard_run(text: str) -> bool:
    """Whether a text is a run on the keyboard, in the alphabet or of digits, in either direction, cyclically."""
    return any(text in turned * 2 for run in RUNS for turned in (run, run[::-1]) if len(text) <= len(run))
