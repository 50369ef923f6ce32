"""The comparison with time series as people hand it on: report, workbook, figures and tables in one folder."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from fowtio import __version__
from fowtio.write import validation_tables as tables
from fowtio.write.atomic import atomic_folder
from fowtio.write.excel import _Book
from fowtio.write.provenance import versions
from fowtio.write.quantities import slug, state_label
from fowtio.write.report import Card, Section, environment
from fowtio.write.style import save
from fowtio.write.table import Table
from fowtio.write.validation_figures import drawings

REPORT, WORKBOOK = "validation.html", "validation.xlsx"
THESIS_CASE = "OC4 DeepCwind"  # studies of which the source thesis shows the same pictures


def write_comparison(
    found: Sequence, folder, *, model=None, decays: Sequence = (), figures: bool = True, extra_sections: Sequence[Section] = (),
    progress: Callable[[str], None] = lambda text: None,
) -> list[Path]:  # fmt: skip
    """Write report, workbook, figures (PNG, SVG) and tables (CSV) of validations into a folder; return the files.

    Report and workbook need the model; decays are decay tests; extra_sections stand in the report before the method. All files
    appear or none.
    """
    folder = Path(folder)
    with atomic_folder(folder) as inside:
        pictures = _draw(found, decays, inside, model, figures, progress)
        for item in found:
            if item.estimate is not None:
                _csv(*tables.spectra_numbers(item)[:2], inside / f"{slug(item.state)}_{item.kind}.csv")
        if model is not None:
            progress("writing the report")
            (inside / REPORT).write_text(report(model, found, decays, pictures, extra_sections), encoding="utf-8")
            _workbook(model, found, decays, inside / WORKBOOK)
        written = sorted(p.relative_to(inside) for p in inside.rglob("*") if p.is_file())
    return [folder / name for name in written]


def report(model, found: Sequence, decays: Sequence = (), pictures: Sequence = (), extra_sections: Sequence[Section] = ()) -> str:
    """Return the report as one HTML page."""
    sections = [
        _overview(found, decays), _doubts(found, decays), *(_state_section(model, item, pictures) for item in found),
        *([_decay_section(decays, pictures)] if decays else []), *extra_sections, _method_section(found), _provenance(model, found, decays),
    ]  # fmt: skip
    return environment().get_template("site.html.j2").render(
        kind="Code-to-code validation against time-domain simulations", title=model.case.title or model.case.path.stem,
        origin=f"Study {model.case.path.name}, OpenFAST deck {model.deck.path.name}", version=__version__, date=datetime.date.today().isoformat(),
        cards=cards(found, decays), sections=[(f"part-{n}", s) for n, s in enumerate(sections, start=1)],
    )  # fmt: skip


def cards(found: Sequence, decays: Sequence = ()) -> list[Card]:
    """Return the key figures of the overview: the verdict, the worst channel of each comparison, the decay tests."""
    judged = [v for i in found for c in i.channels for v in c.verdicts] + ["within" if d.passed else "outside" for d in decays]
    chance = judged.count("within scatter")
    wrong = sum(f.severity == "error" for i in found for f in i.findings)
    notes = [f"{chance} more inside the seeds' own scatter"] if chance else []
    notes.append(f"{wrong} doubts about the reference" if wrong else "nothing wrong with the reference")
    out = [
        Card(
            label="Judged figures inside their tolerance",
            value=f"{judged.count('within')} of {len(judged)}",
            note="; ".join(notes),
        )
    ]
    for item in found:
        worst = [c for c in item.channels if c.verdict != "not judged"]
        if not worst:
            continue
        key = (lambda c: abs(c.mean_error)) if item.kind == "mean" else (lambda c: abs(c.std_error))
        c = max(worst, key=key)
        value = c.mean_error if item.kind == "mean" else c.std_error
        what = "mean" if item.kind == "mean" else "σ"
        out.append(
            Card(
                label=f"Largest error of {what}, {item.state}",
                value=f"{100 * value:+.1f} %".replace("-", "−"),
                note=c.name,
            )
        )
    if decays:
        d = max(decays, key=lambda x: abs(x.period_error))
        out.append(
            Card(
                label="Largest error of a decay's period",
                value=f"{100 * d.period_error:+.2f} %".replace("-", "−"),
                note=d.channel,
            )
        )
    return out


def _overview(found, decays) -> Section:
    words = (
        "<p>Errors in per cent, and small what is allowed. Green: within the tolerance of the study. Yellow: outside, but within the 95 % interval of the "
        "reference's own seeds. Red: outside. Grey: no tolerance named. In wind, σ is judged twice: in the wind that the reference's rotor felt, and in the state's.</p>"
    )
    return Section(
        title="Overview", content=(words, traffic_lights(found, decays)), fold=(tables.overview(found, decays),)
    )


def traffic_lights(found: Sequence, decays: Sequence = ()) -> str:
    """Return the overview as an HTML table: a row for every channel, a coloured cell for every judged error."""
    heads, cells = [], {}
    for n, item in enumerate(found):
        judged = [("σ", "std", [(c, c.std_error, c.std_verdict) for c in item.channels]), ("σ, state's wind", "std", [(c, c.std_error_state, c.state_verdict) for c in item.channels]), ("mean", "mean", [(c, c.mean_error, c.mean_verdict) for c in item.channels]),
                  ("RAO", "rao", [(c, c.rao_error, c.rao_verdict) for c in item.channels])]  # fmt: skip
        for label, key, values in judged:
            if (label != "σ" and all(v == "not judged" for *_, v in values)) or all(
                not np.isfinite(e) for _, e, _ in values
            ):
                continue
            heads.append((tables.title(item), label))
            for c, error, verdict in values:
                cells[c.name, n, label] = (error, getattr(c.tolerance, key), verdict)
    keys = [
        (n, label)
        for n, item in enumerate(found)
        for label in ("σ", "σ, state's wind", "mean", "RAO")
        if any(k[1:] == (n, label) for k in cells)
    ]
    if decays:
        heads.append(("decay", "period"))
        keys.append((-1, "period"))
        cells |= {
            (d.channel, -1, "period"): (d.period_error, d.tolerance, "within" if d.passed else "outside")
            for d in decays
        }
    names = list(dict.fromkeys(name for name, *_ in cells))
    spans = [(title, sum(h[0] == title for h in heads)) for title in dict.fromkeys(h[0] for h in heads)]
    first = "".join(f'<th class="n" colspan="{count}">{_escaped(title)}</th>' for title, count in spans)
    second = "".join(f'<th class="n">{_escaped(label)}</th>' for _, label in heads)
    body = "".join(
        f"<tr><td class='s'>{_escaped(name)}</td>" + "".join(_light(cells.get((name, *key))) for key in keys) + "</tr>"
        for name in names
    )
    return f"<style>{_LIGHTS}</style><div class='table lights'><table><thead><tr><th></th>{first}</tr><tr><th>Channel</th>{second}</tr></thead><tbody>{body}</tbody></table></div>"


_COLOURS = {"within": "#1a9850", "within scatter": "#e6a800", "outside": "#d73027", "not judged": "#9aa3ad"}
_LIGHTS = (
    ".lights td.n{white-space:nowrap}.light{display:inline-block;width:.72em;height:.72em;border-radius:50%;margin-right:.45em;print-color-adjust:exact;"
    "-webkit-print-color-adjust:exact}.lights small{color:var(--soft)}.lights thead tr:first-child th{border-bottom:0;padding-bottom:0}"
)


def _light(cell) -> str:
    if cell is None or not np.isfinite(cell[0]):
        return "<td class='n'></td>"
    error, allowed, verdict = cell
    limit = f" <small>{100 * allowed:g}</small>" if allowed else " <small>–</small>"
    return (
        f"<td class='n' title='{_escaped(verdict)}'><span class='light' style='background:{_COLOURS[verdict]}'></span>"
        f"<span hidden>{_escaped(verdict)}: </span>{100 * error:+.2f}{limit}</td>".replace("+-", "−").replace(
            ">-", ">−"
        )
    )


def _doubts(found, decays) -> Section:
    table = tables.findings(found, decays)
    words = "<p>Checked: signs, units, time axes, wave channels, wave height and period, lengths of the records, missing channels, records given twice.</p>"
    return Section(
        title="Is it the right reference?", content=(words, table if table is not None else "<p>Nothing to note.</p>")
    )


def _state_section(model, item, pictures) -> Section:
    state = next(s for s in model.states if s.name == item.state)
    words = f"<p>{_escaped(state_label(state))}.</p>"
    own = tuple(p for p in pictures if p.group == f"validation {item.state}") if item.kind != "mean" else ()
    more = (tables.bands(item),) if item.estimate is not None else ()
    lack = tables.lack(item)
    return Section(
        title=f"{item.state}: {tables.KINDS[item.kind]}",
        content=(words, *tables.channels(item), *own, *([lack] if lack else [])),
        fold=(*more, tables.mapping(item)),
    )


def _decay_section(decays, pictures) -> Section:
    return Section(
        title="Decay tests", content=(tables.decay_table(decays), *(p for p in pictures if p.group == "decays"))
    )


def _method_section(found) -> Section:
    rules = (
        "σ error: standard deviation of the model over that of the reference, less one. The model is taken in the reference's own wave spectrum, and in the wind that "
        "its rotor felt as far as thrust and motion of the records tell; the state's own spectra are judged too, where the seeds' 95 % interval may count.",
        "RAO and spectrum error: √(Σ(a − a_ref)²/Σ a_ref²) of amplitudes over 0.006 to 0.199 Hz: an error of |H| weighted by the energy of the response.",
        "|H|₂ = √(Syy/Sηη) holds all of the energy, H₁ = Sηy/Sηη the part that follows the waves; its bounds are those of Bendat and Piersol.",
        "The model's |H|² is seen through the same spectral window. A record whose mean was removed lacks what is slower than itself; so does the model in wind.",
        "Mean error: over the reference's mean, or over its standard deviation where that is larger.",
        "Quadratic drag: the same model with the drag force itself, driven by the reference's own waves. Memory: with HydroDyn's convolution of the radiation "
        "kernel, its length, step and lag, besides.",
        "Verdicts: within the tolerance that the study names; else within the 95 % interval of the reference's seeds (only in wind); else outside.",
    )
    return Section(
        title="How it was measured",
        content=(tables.settings(found), "<ul>" + "".join(f"<li>{_escaped(r)}</li>" for r in rules) + "</ul>"),
    )


def _provenance(model, found, decays) -> Section:
    name = model.case.path.name
    command = f'fowtio validate "{name}" -o validation' if " " in name else f"fowtio validate {name} -o validation"
    options = model.case.options
    words = (
        f"<p>To make this report again, in the folder of the study:</p><pre>{_escaped(command)}</pre><p>Drag linearised for the {_escaped(options.drag_model)} velocity; "
        f"excitation below the data: {_escaped(options.low_frequency_excitation)}; wind {_escaped(options.wind_spectrum)}, {_escaped(options.wind_averaging)}.</p>"
    )
    return Section(
        title="Versions, settings and files", content=(words, versions()), fold=(tables.files(model, found, decays),)
    )


def _draw(found, decays, folder: Path, model, figures: bool, progress) -> list:
    if not figures:
        return []
    out = []
    for drawing in drawings(found, decays, thesis=model is not None and THESIS_CASE in model.case.title):
        progress(f"drawing {drawing.title}")
        out.append(save(drawing, folder))
    return out


def _workbook(model, found, decays, path: Path) -> None:
    book = _Book()
    book.sheet("Overview", [tables.overview(found, decays)], title=model.case.title)
    doubts = tables.findings(found, decays)
    book.sheet("Doubts", [doubts if doubts is not None else _none("findings", "Doubts about the reference")])
    for item in found:
        more = [
            t
            for t in (
                *tables.channels(item),
                tables.bands(item) if item.estimate is not None else None,
                tables.lack(item),
                tables.mapping(item),
            )
            if t is not None
        ]
        book.sheet(tables.title(item), more)
        if item.estimate is not None:
            book.numbers(f"{item.state} numbers", *tables.spectra_numbers(item))
    if decays:
        book.sheet("Decay tests", [tables.decay_table(decays)])
    book.sheet("Settings", [tables.settings(found), versions()])
    book.sheet("Files", [tables.files(model, found, decays)])
    book.save(path)


def _none(name: str, title: str) -> Table:
    from fowtio.write.table import Column

    return Table(name=name, title=title, columns=(Column(name="What"),), rows=(("none",),))


def _csv(headings: Sequence[str], values: np.ndarray, path: Path) -> None:
    with path.open("w", encoding="utf-8") as stream:
        np.savetxt(stream, values, fmt="%.6g", delimiter=",", header=",".join(headings), comments="")


def _escaped(text: str) -> str:
    from markupsafe import Markup

    return str(Markup.escape(text))
