"""Small spreadsheets, made as their programs make them."""

from __future__ import annotations

import io
import zipfile
from xml.sax.saxutils import escape

Rows = list[list[str | int]]


def xlsx(rows: Rows) -> bytes:
    return workbook(_sheet(rows))


def xlsx_sheets(*sheets: Rows) -> bytes:
    return workbook(*map(_sheet, sheets))


def _sheet(rows: Rows) -> str:
    def cell(value: str | int) -> str:
        inline = f'<c t="inlineStr"><is><t>{escape(str(value))}</t></is></c>'
        return f"<c><v>{value}</v></c>" if isinstance(value, int) else inline

    body = "".join(f'<row r="{place}">{"".join(map(cell, row))}</row>' for place, row in enumerate(rows, 1))
    return f"<sheetData>{body}</sheetData>"


def workbook(*sheets: str) -> bytes:
    main = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
    rels = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
    packages = "http://schemas.openxmlformats.org/package/2006/relationships"
    places = range(1, len(sheets) + 1)
    names = "".join(f'<sheet name="S{place}" sheetId="{place}" r:id="b{place}"/>' for place in places)
    targets = "".join(
        f'<Relationship Id="b{place}" Type="{rels}/worksheet" Target="worksheets/sheet{place}.xml"/>'
        for place in places
    )
    return zipped(
        {
            "_rels/.rels": f'<Relationships xmlns="{packages}"><Relationship Id="a" Type="{rels}/officeDocument" '
            'Target="xl/workbook.xml"/></Relationships>',
            "xl/workbook.xml": f'<workbook {main} xmlns:r="{rels}"><sheets>{names}</sheets></workbook>',
            "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{packages}">{targets}</Relationships>',
            **{
                f"xl/worksheets/sheet{place}.xml": f"<worksheet {main}>{sheet}</worksheet>"
                for place, sheet in enumerate(sheets, 1)
            },
        }
    )


def ods(rows: Rows, repeated: int = 1) -> bytes:
    office, table, words, manifest = (
        f"urn:oasis:names:tc:opendocument:xmlns:{one}:1.0" for one in ("office", "table", "text", "manifest")
    )
    body = "".join(
        "<table:table-row>"
        + "".join(
            f'<table:table-cell office:value-type="string"><text:p>{escape(str(value))}</text:p></table:table-cell>'
            for value in row
        )
        + "</table:table-row>"
        for row in rows
    )
    body += (
        f'<table:table-row table:number-rows-repeated="{repeated}"><table:table-cell office:value-type="string" '
        'table:number-columns-repeated="16384"><text:p>x</text:p></table:table-cell></table:table-row>'
        if repeated > 1
        else ""
    )
    return zipped(
        {
            "mimetype": "application/vnd.oasis.opendocument.spreadsheet",
            "META-INF/manifest.xml": f'<m:manifest xmlns:m="{manifest}"/>',
            "content.xml": f'<office:document-content xmlns:office="{office}" xmlns:table="{table}" '
            f'xmlns:text="{words}"><office:body><office:spreadsheet><table:table table:name="A">{body}</table:table>'
            "</office:spreadsheet></office:body></office:document-content>",
        }
    )


def zipped(files: dict[str, str]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text, zipfile.ZIP_STORED if name == "mimetype" else None)
    return out.getvalue()
