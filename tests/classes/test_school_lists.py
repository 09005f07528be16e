"""The lists that school programs write, in one table: read rightly, refused rightly, or told."""

from __future__ import annotations

import pytest

from server.base.errors import Invalid
from server.classes.encodings import decode_text, find_damaged_word, repair_word
from server.classes.full_names import split_full_name
from server.classes.headers import recognise_header
from server.classes.roster import ReadingChoice, UndecidedColumns, read_roster
from tests.support.spreadsheets import ods, workbook, xlsx, xlsx_sheets
from tests.support.tables import folded

Person = tuple[str, ...]
ANA, INES = ("Petit", "Ana"), ("Lacroix", "Inès")


def text(*lines: str, encoding: str = "utf-8", end: str = "\r\n") -> bytes:
    return (end.join(lines) + end).encode(encoding)


#: Name of the kind, file, people as family name, given name and what is told of them, and columns left aside.
READ: list[tuple[str, bytes, list[Person], list[str]]] = [
    (
        "Pronote: one column, capitals",
        text(
            "Élève;Né(e) le;Sexe;Classe;Options",
            "N'DIAYE Aïssatou;04/03/2008;F;MPSI1;LV1",
            "DE LA TOUR Jean-Noël;5/3/2008;M;MPSI1;",
            "O’BRIEN Chloé;;;MPSI1;",
            encoding="cp1252",
        ),
        [("N'DIAYE", "Aïssatou"), ("DE LA TOUR", "Jean-Noël"), ("O’BRIEN", "Chloé")],
        ["Né(e) le", "Sexe", "Classe", "Options"],
    ),
    (
        "SIECLE: qualifiers and stars",
        text(
            "Identifiant unique*;Premier prénom*;Deuxième prénom;Nom de famille*;Nom d’usage;Division*",
            "A1;Inès;Jeanne;Lacroix;;P1",
            "A2;Ana;;Durand;Petit;P1",
        ),
        [("Lacroix", "Inès"), ("Petit", "Ana")],
        ["Identifiant unique*", "Deuxième prénom", "Division*"],
    ),
    (
        "SIECLE: numbered given names, parents beside",
        text(
            "Division;Nom de naissance;Nom d'usage;Prénom 1;Prénom 2;INE;Nom responsable 1;Prénom du père;"
            "Courriel responsable",
            "P1;LACROIX;;Inès;Léa;1A;LACROIX;Paul;p@x.fr",
            encoding="cp1252",
        ),
        [("LACROIX", "Inès")],
        ["Division", "Prénom 2", "INE", "Nom responsable 1", "Prénom du père", "Courriel responsable"],
    ),
    (
        "Moodle",
        text(
            "\ufeffPrénom,Nom de famille,Numéro d'identification,Établissement,Adresse de courriel",
            "Inès,Lacroix,226,Univ,ines@univ.fr",
        ),
        [(*INES, "", "ines@univ.fr")],
        ["Numéro d'identification", "Établissement"],
    ),
    (
        "Pronote: groups in brackets",
        text("Élève;Groupes", "PETIT Ana;[P1_G1], [P1_LV2]", "LACROIX Inès;[P1_G2]"),
        [("PETIT", "Ana", "", "", "P1_G1", "P1_LV2"), ("LACROIX", "Inès", "", "", "P1_G2")],
        [],
    ),
    (
        "Google: headers that say what is required",
        text("First Name [Required],Last Name [Required],Email Address [Required]", "Ana,Petit,a@x.fr"),
        [(*ANA, "", "a@x.fr")],
        [],
    ),
    (
        "Moodle, in English",
        text("First name,Last name,Email address,Groups", "Ana,Petit,a@x.fr,G1|G2"),
        [(*ANA, "", "a@x.fr", "G1", "G2")],
        [],
    ),
    ("one-word headers", text("lastname,firstname,username", "Petit,Ana,apetit"), [(*ANA, "apetit")], []),
    ("camel case", text("familyName,givenName,eMail", "Petit,Ana,a@x.fr"), [(*ANA, "", "a@x.fr")], []),
    (
        "Apogée: columns of groups",
        text(
            "Code étudiant;Nom;Prénom;Groupe TD;Groupe TP;Mail",
            "22600000;PETIT;Ana;TD1;TP2;a@etu.fr",
            encoding="cp1252",
        ),
        [("PETIT", "Ana", "", "a@etu.fr", "TD1", "TP2")],
        ["Code étudiant"],
    ),
    (
        "Apogée: groups told by their header",
        text("N° étudiant;Nom;Prénom;TD;TP", "226;Petit;Ana;1;2"),
        [(*ANA, "226", "", "TD 1", "TP 2")],
        [],
    ),
    (
        "École directe",
        text(
            "Nom;Prénom;Classe;Email élève;Email parent 1;Adresse;Code postal",
            "PETIT;Ana;2A;a@x.fr;m@x.fr;1 rue X;75000",
        ),
        [("PETIT", "Ana", "", "a@x.fr")],
        ["Classe", "Email parent 1", "Adresse", "Code postal"],
    ),
    (
        "Parcoursup: title rows",
        text(
            "Liste des candidats admis",
            "",
            "Formation : MPSI",
            "Numéro candidat;Civilité;Nom;Prénom;Deuxième prénom;Adresse électronique",
            "77;Mme;PETIT;Ana;Lou;a@x.fr",
        ),
        [("PETIT", "Ana", "", "a@x.fr")],
        ["Numéro candidat", "Civilité", "Deuxième prénom"],
    ),
    (
        "EDT: tabulations",
        text("NOM\tPRÉNOM\tCLASSE\tGROUPES", "PETIT\tAna\t2A\tG1, G2"),
        [("PETIT", "Ana", "", "", "G1", "G2")],
        ["CLASSE"],
    ),
    ("bars", text("Nom|Prénom|Login", "Petit|Ana|ana"), [(*ANA, "ana")], []),
    (
        "quotes and Excel's first line",
        text("sep=;", '"Nom";"Prénom"', '"Petit ; Le Grand";"Ana"'),
        [("Petit ; Le Grand", "Ana")],
        [],
    ),
    ("Google Classroom", text("Last Name,First Name,Email Address", "Petit,Ana,a@x.fr"), [(*ANA, "", "a@x.fr")], []),
    (
        "one column, both orders told",
        text("Prénom Nom", "Ana Petit", "Jean-Noël De La Tour"),
        [ANA, ("De La Tour", "Jean-Noël")],
        [],
    ),
    (
        "one column, given name first",
        text("Étudiant", "Ana PETIT", "Ian McDONALD"),
        [("PETIT", "Ana"), ("McDONALD", "Ian")],
        [],
    ),
    ("one column with a comma", text("Nom complet", '"Petit, Ana"', encoding="utf-8"), [ANA], []),
    (
        "Excel: title, blank rows, numbers",
        xlsx(
            [
                ["Lycée Pascal — MPSI 1"],
                [],
                ["N°", "NOM", "Prénom", "Groupe"],
                [1, "PETIT", "Ana  ", "G1"],
                [],
                [2, "LACROIX", "Inès", "G2"],
            ]
        ),
        [("PETIT", "Ana", "", "", "G1"), ("LACROIX", "Inès", "", "", "G2")],
        ["N°"],
    ),
    (
        "headers merged over two rows",
        xlsx([["Nom", "Prénom", "Groupes", ""], ["", "", "TD", "TP"], ["PETIT", "Ana", "A", "B"]]),
        [("PETIT", "Ana", "", "", "TD A", "TP B")],
        [],
    ),
    (
        "a header merged over two names",
        ods([["Nom", "", "Prénom"], ["de famille", "d'usage", ""], ["DURAND", "PETIT", "Ana"]]),
        [("PETIT", "Ana")],
        [],
    ),
    ("Excel: a cover first", xlsx_sheets([["À lire"]], [["Nom", "Prénom"], ["Petit", "Ana"]]), [ANA], []),
    ("LibreOffice", ods([["nom", "prénom"], ["Petit", "Ana"]]), [ANA], []),
    ("UTF-16 with its mark", text("Nom\tPrénom", "Lacroix\tInès", encoding="utf-16"), [INES], []),
    ("UTF-16 without a mark", text("Nom\tPrénom", "Lacroix\tInès", encoding="utf-16-le"), [INES], []),
    (
        "Mac",
        text("Nom;Prénom", "Lacroix;Inès", "Legué;Chloé", encoding="mac_roman", end="\r"),
        [INES, ("Legué", "Chloé")],
        [],
    ),
    (
        "MS-DOS",
        text("Nom;Prénom", "Lacroix;Inès", "Guérin;François", encoding="cp850"),
        [INES, ("Guérin", "François")],
        [],
    ),
    (
        "UTF-8 read as Windows before",
        text("nom;prenom", "LeguÃ©;ChloÃ©", "Lacroix;InÃ¨s"),
        [("Legué", "Chloé"), INES],
        [],
    ),
    ("Mac read as Windows before", text("nom;prenom", "LeguŽ;ChloŽ"), [("Legué", "Chloé")], []),
    (
        "two encodings in one file",
        text("nom;prenom", "Lacroix;Inès") + text("Legué;Chloé", encoding="cp1252"),
        [INES, ("Legué", "Chloé")],
        [],
    ),
    (
        "invisible characters",
        text(
            "\u200bnom;prenom\u00a0;email",
            "Lacroix;In\u00ade\u0300s;ines@exemple.fr\u200b",
            "\u200bPetit;\u202fAna;ana@exemple.fr",
        ),
        [(*INES, "", "ines@exemple.fr"), (*ANA, "", "ana@exemple.fr")],
        [],
    ),
    (
        "namesakes with birth dates",
        text("Nom;Prénom;Date de naissance", "Lacroix;Inès;1/2/2008", "Lacroix;Inès;3/4/2008"),
        [INES, INES],
        ["Date de naissance"],
    ),
    ("headers again on each page", text("Nom;Prénom", "Petit;Ana", "Nom;Prénom", "Lacroix;Inès"), [ANA, INES], []),
    ("an address with its name", text("Nom;Prénom;E-mail", "Petit;Ana;Ana Petit <A@x.fr>"), [(*ANA, "", "a@x.fr")], []),
]


@pytest.mark.parametrize(("content", "people", "ignored"), [row[1:] for row in READ], ids=[row[0] for row in READ])
def test_a_school_list_is_read(content: bytes, people: list[Person], ignored: list[str]) -> None:
    roster = read_roster(content)
    assert roster.rejected == ()
    shown = [(line.family_name, line.given_name, line.login, line.email, *line.groups) for line in roster.lines]
    assert shown == [(*person, *[""] * (4 - len(person))) for person in people]
    assert list(roster.ignored_headers) == ignored


FORMULA = workbook(
    '<sheetData><row r="1"><c r="A1" t="inlineStr"><is><t>Nom</t></is></c><c r="B1" t="inlineStr"><is><t>Prénom</t>'
    '</is></c><c r="C1" t="inlineStr"><is><t>Âge</t></is></c></row><row r="3"><c r="A3" t="inlineStr"><is><t>Petit</t>'
    '</is></c><c r="B3"><f>PROPER("ana")</f><v></v></c><c r="C3"><f>1+1</f></c></row></sheetData>'
)
TOLD: list[tuple[str, bytes, int, str]] = [
    ("a formula without a value", FORMULA, 3, "la cellule B3 est une formule sans valeur"),
    ("an error of the sheet", text("Nom;Prénom", "Petit;#N/A"), 2, "#N/A"),
    ("a total under the names", text("N°;Nom;Prénom", "1;Petit;Ana", "Total;1"), 3, "aucune lettre"),
    ("a total beside its word", text("Élève;Trinôme", "PETIT Ana;1", "Total;1"), 3, "ne paraît pas nommer un élève"),
    ("a line twice", text("Nom;Prénom", "Petit;Ana", "PETIT;ana"), 3, "qu’à la ligne 2"),
    (
        "namesakes without anything else",
        text("Nom;Prénom;Groupe", "Petit;Ana;1", "Petit;Ana;2"),
        3,
        "ce sont deux personnes",
    ),
    (
        "accents that nothing mends",
        text("Nom;Prénom", "Petit;Chlo\ufffd"),
        2,
        "les accents de « Chlo\ufffd » sont abîmés",
    ),
    (
        "a total under the list",
        text("Nom;Prénom", "Petit;Ana", "", "Effectif : 12;"),
        4,
        "ne paraît pas nommer un élève",
    ),
    ("a control character", text("Nom;Prénom", "Petit;A\x01na"), 2, "(U+0001)"),
    ("a login of two alphabets", text("Nom;Prénom;Login", "Petit;Ana;\u0430na"), 2, "cyrilliques et latines"),
    ("an address for a name", text("Nom;Prénom", "a@x.fr;"), 2, "à la place du nom"),
    ("too many groups", text("Nom;Groupe", f"Petit;{','.join(map(str, range(25)))}"), 2, "24 groupes au plus"),
]


@pytest.mark.parametrize(("content", "line", "words"), [row[1:] for row in TOLD], ids=[row[0] for row in TOLD])
def test_a_line_that_is_not_read_is_told_with_its_reason(content: bytes, line: int, words: str) -> None:
    (rejected,) = read_roster(content).rejected
    assert rejected.line == line
    assert words in rejected.reason


REFUSED: list[tuple[str, bytes, str]] = [
    ("empty", b"", "vide"),
    ("a printed page", b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n1 0 obj", "PDF"),
    ("blank lines", b"\r\n ; ;\r\n", "vide"),
    ("no headers", text("Petit;Ana", "Lacroix;Inès"), "vingt premières lignes"),
    ("no names", text("Login;Groupe", "ana;1"), "vingt premières lignes"),
    ("two names that differ", text("Nom;Last name", "Petit;Grand"), "deux colonnes donnent « nom »"),
    ("a web page called .xls", b"<html><table><tr><td>Nom</td></tr></table></html>", "page web"),
    ("an old workbook", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "ancien format"),
    ("bytes", b"\x00\x01\x02\x03\x04", "pas un texte"),
]


@pytest.mark.parametrize(("content", "words"), [row[1:] for row in REFUSED], ids=[row[0] for row in REFUSED])
def test_a_file_that_is_no_list_is_refused_with_what_to_do(content: bytes, words: str) -> None:
    with pytest.raises(Invalid) as refused:
        read_roster(content)
    assert words in refused.value.detail


def test_a_person_says_which_column_is_which() -> None:
    content = text("Kind;Vorname;Stufe", "Petit;Ana;1", "Lacroix;Inès;2")
    with pytest.raises(UndecidedColumns) as asked:
        read_roster(content)
    assert asked.value.source.rows[0].cells == ("Kind", "Vorname", "Stufe")
    roster = read_roster(content, ReadingChoice(("nom", "prenom", "groupe"), first_line=2))
    assert [(line.line, line.name, line.groups) for line in roster.lines] == [
        (2, "Ana Petit", ("1",)),
        (3, "Inès Lacroix", ("2",)),
    ]
    with pytest.raises(UndecidedColumns, match="quelle colonne donne le nom"):
        read_roster(content, ReadingChoice(("", "", "groupe")))
    headless = read_roster(text("Petit;Ana"), ReadingChoice(("nom", "prenom")))
    assert [line.line for line in headless.lines] == [1]


def test_what_the_headers_say_counts_where_a_person_says_the_same() -> None:
    content = text("Nom de naissance;Nom d'usage;Prénom;TD;TP", "DURAND;PETIT;Ana;1;2")
    by_hand = ReadingChoice(("nom", "nom", "prenom", "groupe", "groupe"))
    assert read_roster(content, by_hand).lines == read_roster(content).lines


def test_names_that_cannot_be_cut_stay_whole_and_are_told() -> None:
    roster = read_roster(text("Élève", "Nguyen Thi Anh", "Lacroix Inès", "PETIT Ana"))
    assert [line.name for line in roster.lines] == ["Nguyen Thi Anh", "Lacroix Inès", "Ana PETIT"]
    assert "2 noms complets" in roster.warnings[0]
    assert "lignes 2, 3" in roster.warnings[0]
    (warning,) = read_roster(text("Élève", "Lacroix Inès")).warnings
    assert warning.startswith("Un nom complet ne se coupe pas sûrement")
    cut = read_roster(text("Élève", "Lacroix Inès"), ReadingChoice(("nom_prenom",), first_line=2))
    assert (cut.lines[0].family_name, cut.lines[0].given_name) == INES


@folded(
    ("header", "field"),
    [
        ("Nom", "nom"), ("NOM *", "nom"), ("Nom de famille", "nom"), ("Last name", "nom"), ("Surname", "nom"),
        ("Nom d’usage", "nom"), ("Nom de l'élève", "nom"), ("Nom patronymique", "nom"), ("Prénom(s)", "prenom"),
        ("1er prénom", "prenom"), ("PRENOM USUEL", "prenom"), ("Prénom de l’étudiant·e", "prenom"), ("Prénom 3", None),
        ("Autres prénoms", None), ("Nom et prénom", "nom_prenom"), ("Prénom, nom", "prenom_nom"),
        ("Élèves", "nom_complet"),
        ("Full name", "nom_complet"), ("Apprenant", "nom_complet"), ("E-mail", "email"), ("Mél.", "email"),
        ("Adresse mail étudiant", "email"), ("Courriel établissement", "email"), ("Email de la mère", None),
        ("Identifiant", "identifiant"), ("Login ENT", "identifiant"), ("Nom d’utilisateur", "identifiant"),
        ("User name", "identifiant"), ("Identifiant national", "numero"), ("INE", "numero"), ("Matricule", "numero"),
        ("Code postal", None), ("Code", None), ("Groupe(s)", "groupe"), ("Gr. TP", "groupe"),
        ("Gp", "groupe"), ("Trinôme", "groupe"),
        ("Sous-groupe", "groupe"),
        ("Nombre de groupes", None), ("Division", "classe"), ("Code classe", "classe"), ("Classe d'origine", None),
        ("Née le", "naissance"), ("Date de naissance (jj/mm/aaaa)", "naissance"), ("Lieu de naissance", None),
        ("Date d’inscription", None), ("Nom du tuteur", None), ("Nom de la commune", None), ("Téléphone", None),
        ("Liste des élèves de la classe", None), ("", None),
    ],
)  # fmt: skip
def test_a_header_is_known_by_its_meaning(header: str, field: str | None) -> None:
    assert recognise_header(header).field == field


@pytest.mark.parametrize(
    ("full", "family", "given"),
    [
        ("D'ALMEIDA Zoé", "D'ALMEIDA", "Zoé"), ("d'ALMEIDA Zoé", "d'ALMEIDA", "Zoé"),
        ("LE GALL Yann", "LE GALL", "Yann"),
        ("Jean de LA TOUR", "de LA TOUR", "Jean"), ("van der BERG Luc", "van der BERG", "Luc"),
        ("MacDONALD Ian", "MacDONALD", "Ian"), ("O BRIEN Chloé", "O BRIEN", "Chloé"),
        ("NGUYEN Thi Anh", "NGUYEN", "Thi Anh"),
        ("ŒUVRARD Clémence", "ŒUVRARD", "Clémence"), ("Mme DUPONT-MARTIN Ève", "DUPONT-MARTIN", "Ève"),
        ("STRAUß Ann", "STRAUß", "Ann"), ("Madonna", "Madonna", ""),
    ],
)  # fmt: skip
def test_a_full_name_is_cut_at_its_capitals(full: str, family: str, given: str) -> None:
    split = split_full_name(full)
    assert (split.family, split.given, split.whole) == (family, given, False)


@pytest.mark.parametrize("full", ["Dupont Marie", "DUPONT MARIE", "Nguyen Thi Anh", "李 明", "DUPONT Jean MARTIN"])
def test_a_full_name_is_never_cut_on_a_guess(full: str) -> None:
    assert split_full_name(full).family == full
    assert split_full_name(full).whole


NAMES = [
    "Chloé",
    "Zoé",
    "Hélène",
    "Noël",
    "Maïa",
    "François",
    "Jérôme",
    "Benoît",
    "Gaël",
    "LEFÈVRE",
    "Étienne",
    "ÉTIENNE",
    "Agnès",
    "Anaïs",
    "Inès",
    "MÜLLER",
]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252", "iso8859_15", "mac_roman", "cp850"])
def test_an_encoding_is_judged_by_what_comes_out(encoding: str) -> None:
    names = "\n".join(["nom", *NAMES])
    assert decode_text(names.encode(encoding)).text == names


@folded("name", NAMES)
@folded("read_as", ["cp1252", "mac_roman", "cp850"])
def test_utf8_read_as_something_else_is_mended(name: str, read_as: str) -> None:
    damaged = name.encode().decode(read_as, errors="replace")
    assert "\ufffd" in damaged or repair_word(damaged) == name


@folded(
    "name",
    [*NAMES, "D’ALMEIDA", "D‘Almeida", "McÉwan", "Žižek", "Škoda", "Łukasz", "Dvořák", "ŠIMŮNEK", "«Zoé»", "“Zoé”",
     "Ÿves",
     "HAŸ", "L'Haÿ", "CŒUR", "Abd-el-Kadér", "É.Dupont", "Nguyễn", "Ђорђе", "山田", "LÉa"],
)  # fmt: skip
def test_honest_names_are_not_called_damaged(name: str) -> None:
    assert find_damaged_word(name) == ""
    assert decode_text(f"nom\n{name}".encode()).text == f"nom\n{name}"


def test_an_encoding_in_doubt_is_told() -> None:
    roster = read_roster(b"nom;prenom\n\x90lne;A\n")
    assert roster.source.other_encodings or roster.warnings
    doubtful = decode_text("nom\nŒuvrard".encode("mac_roman"))
    assert "mac_roman" in doubtful.others
    assert decode_text("nom\nŒuvrard".encode("mac_roman"), "mac_roman").text == "nom\nŒuvrard"
    with pytest.raises(Invalid, match="encodage"):
        decode_text(b"a", "klingon")
