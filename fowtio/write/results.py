"""All results of a study in one folder: netCDF, workbook, figures, report.

model and loads are those of `fowtio.workflow`: a Model, and a sequence of StateLoads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from fowtio.write.atomic import atomic_folder
from fowtio.write.excel import write_excel
from fowtio.write.netcdf import write_netcdf

NETCDF, WORKBOOK, REPORT, FIGURES = "results.nc", "results.xlsx", "report.html", "figures"


def write_results(
    model,
    loads: Sequence,
    folder: str | Path,
    *,
    figures: bool = True,
    report: bool = True,
    extra_sections: Sequence = (),
    progress: Callable[[str], None] = lambda text: None,
) -> list[Path]:
    """Write the results of a study into a folder and return the paths of the files; all appear or none.

    figures as PNG and SVG, in the report too; report as HTML, with extra_sections (`fowtio.write.report.Section`);
    progress is told what is being written. Raises ValueError without results.
    """
    if not loads:
        raise ValueError("there are no results to write: the study has no states")
    folder = Path(folder)
    with atomic_folder(folder) as temporary:
        progress("writing tables")
        write_netcdf(temporary / NETCDF, model, loads)
        write_excel(temporary / WORKBOOK, model, loads)
        pictures = _draw(model, loads, temporary / FIGURES, progress) if figures else []
        if report:
            progress("writing the report")
            from fowtio.write.report import write_report

            write_report(temporary / REPORT, model, loads, pictures, extra_sections)
        written = sorted(p.relative_to(temporary) for p in temporary.rglob("*") if p.is_file())
    return [folder / p for p in written]


def _draw(model, loads, folder: Path, progress) -> list:
    """Draw all figures into a folder."""
    from fowtio.write.figures import drawings
    from fowtio.write.style import save

    folder.mkdir()
    out = []
    for drawing in drawings(model, loads):
        progress(f"drawing {drawing.title}")
        out.append(save(drawing, folder))
    return out
