"""A saved model instead of a structure with contacts: the key `model.file`."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from slipmode.rom import Model
from slipmode.rom.errors import SlipmodeError
from slipmode.runner.scene.sections import ModelOptions
from slipmode.runner.scene.toml_table import Table


def read_saved_model(root: Table, folder: Path) -> Model | None:
    """Return the model that `model.file` names, or None without this key.

    Raises SlipmodeError if the file is refused, or the scene gives what the model has already or
    what it does not have.
    """
    table = root["model"]
    if table["file"] is None:
        return None
    path = folder.absolute() / table["file"]
    try:
        stat = path.stat()
        model = _loaded(path, stat.st_mtime_ns, stat.st_size)
    except OSError:
        raise table.error("file", f"no such model file: {str(path)!r}") from None
    except SlipmodeError as refusal:
        raise table.error("file", str(refusal)) from None
    its_own = "must be left out, because the model of model.file has its own"
    for name in ("structure", "friction", "contacts", "preload", "aerodynamics", "modes"):
        if name in root:
            raise root.error(name, its_own)
    for key in table:
        if key in ("table", "transients"):
            reason = "must be left out, because model.file has no structure for full order"
            raise table.error(key, reason)
        if key != "file":
            raise table.error(key, its_own)
    without = "must be left out, because the model of model.file has no contacts"
    if "limits" in root and not model.reduced.n_contacts:
        raise root.error("limits", without)
    if "contact" in root and not model.reduced.n_contacts:
        raise root.error("contact", f"{without}; [[elastic]] windows have its DOFs")
    return model


def options_of(model: Model) -> ModelOptions:
    """Return the [model] options that a saved model stands for; it stays in slow time."""
    return ModelOptions(
        tolerance=model.accuracy.tolerance,
        formulation=model.reduced.formulation,
        amplitude=tuple(model.table.amplitude_range.tolist()),
        table="whole",
        transients="slow",
    )


@lru_cache(maxsize=2)
def _loaded(path: Path, _time: int, _size: int) -> Model:
    """Return the model of a file in a certain state: scenes of a study often have the same one."""
    return Model.load(path)
