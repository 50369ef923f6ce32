"""Where the templates are: in the installed package, or in the checkout."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

_CHECKOUT = Path(__file__).resolve().parents[2] / "templates"


def template_folder(kind: str = "") -> Path:
    """Return the folder of all templates, or of one kind ("report", "fmu", ...); raise FileNotFoundError.

    They are the files of the package `fowtio.templates`; in a checkout, of its `templates` folder.
    """
    try:
        packaged = Path(str(resources.files("fowtio.templates").joinpath(kind or ".")))
    except ModuleNotFoundError:
        packaged = _CHECKOUT / kind
    folder = packaged if packaged.is_dir() else _CHECKOUT / kind
    if not folder.is_dir():
        raise FileNotFoundError(f"no templates in {folder}; is fowtio installed completely?")
    return folder
