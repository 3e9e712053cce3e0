"""A saved model instead of a structure with contacts: the key `model.file`."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from slipmode.rom import Model
from slipmode.rom.errors import SlipmodeError, naming
from slipmode.runner.scene.keys import ModelOptions
from slipmode.runner.scene.toml_table import Content, refuse_given


def read_saved_model(file: str | None, content: Content, folder: Path) -> Model | None:
    """Return the model that `model.file` names, or None without this key.

    Raises SlipmodeError if the file is refused, or the scene gives what the model has already or
    what it does not have.
    """
    if file is None:
        return None
    path = folder.absolute() / file
    try:
        stat = path.stat()
        with naming("model.file"):
            model = _loaded(path, stat.st_mtime_ns, stat.st_size)
    except OSError:
        raise SlipmodeError(f"model.file: no such model file: {str(path)!r}") from None
    its_own = "must be left out, because the model of model.file has its own"
    tables = ("structure", "friction", "contacts", "preload", "aerodynamics", "modes")
    refuse_given(content, "", tables, its_own)
    no_structure = "must be left out, because model.file has no structure for full order"
    refuse_given(content, "model", ("table", "transients"), no_structure)
    refuse_given(content, "model", [key for key in content["model"] if key != "file"], its_own)
    if not model.reduced.n_contacts:
        without = "must be left out, because the model of model.file has no contacts"
        refuse_given(content, "", ("limits",), without)
        refuse_given(content, "", ("contact",), f"{without}; [[elastic]] windows have its DOFs")
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
