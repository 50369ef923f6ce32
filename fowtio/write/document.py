"""A folder of results that is not the main job's: an HTML report, a workbook, figures; all appear or none."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import matplotlib as mpl

from fowtio import __version__
from fowtio.write.atomic import atomic_folder
from fowtio.write.excel import _Book
from fowtio.write.provenance import versions
from fowtio.write.quantities import slug
from fowtio.write.report import Card, Section, environment
from fowtio.write.style import RC, Drawing, Picture, save
from fowtio.write.table import Table


def write_document(
    folder: str | Path,
    *,
    name: str,
    kind: str,
    title: str,
    origin: str,
    cards: Sequence[Card],
    drawings: Callable[[], Sequence[Drawing]],
    sections: Callable[[Mapping[str, Picture]], Sequence[Section]],
    sheets: Sequence[tuple[str, Sequence[Table]]],
    figures: bool = True,
    progress: Callable[[str], None] = lambda text: None,
) -> list[Path]:
    """Write a report, a workbook and figures into a folder and return the files.

    Parameters
    ----------
    folder, name : files are name.html, name.xlsx and figures/*.png, *.svg
    kind, title, origin : heading of the report
    cards : key numbers
    drawings : draws the figures; left out without `figures`
    sections : of the report, given the pictures by name
    sheets : of the workbook, name and tables
    progress : told what is being written
    """
    folder = Path(folder)
    with atomic_folder(folder) as inside:
        pictures = _draw(drawings, inside / "figures", progress) if figures else {}
        progress("writing the report")
        body = [*(s for s in sections(pictures) if s.content), Section(title="Versions", content=(versions(),))]
        text = (
            environment()
            .get_template("site.html.j2")
            .render(
                kind=kind,
                title=title,
                origin=origin,
                cards=cards,
                version=__version__,
                date=datetime.date.today().isoformat(),
                sections=[(slug(s.title), s) for s in body],
            )
        )
        (inside / f"{name}.html").write_text(text, encoding="utf-8")
        book = _Book()
        for sheet, tables in sheets:
            book.sheet(sheet, list(tables), title=title if sheet == sheets[0][0] else "")
        book.save(inside / f"{name}.xlsx")
        written = sorted(p.relative_to(inside) for p in inside.rglob("*") if p.is_file())
    return [folder / p for p in written]


def _draw(drawings: Callable[[], Sequence[Drawing]], folder: Path, progress) -> dict[str, Picture]:
    folder.mkdir()
    out = {}
    with mpl.rc_context(RC):
        found = drawings()
    for drawing in found:
        progress(f"drawing {drawing.title}")
        out[drawing.name] = save(drawing, folder)
    return out


def bullet_list(items: Sequence[str]) -> str:
    """Return sentences as an HTML list, escaped; nothing for none."""
    from markupsafe import Markup

    return "<ul>" + "".join(f"<li>{Markup.escape(i)}</li>" for i in items) + "</ul>" if items else ""
