"""Reading a study file (TOML): a scene, what varies in it, and what is asked of each sample."""

from __future__ import annotations

import copy
import hashlib
import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import log
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom import __version__
from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.files import source_files
from slipmode.runner.recording.channels import MODES
from slipmode.runner.scene.scene import Scene, load_scene, read_scene
from slipmode.runner.scene.toml_table import FINITE, NON_NEGATIVE, POSITIVE, Rule, Table, between
from slipmode.runner.study.outputs.asked import Asked, Curve
from slipmode.runner.study.scene_keys import Content, check_key, get, with_value

_TOP = ("title", "scene", "set", "vary", "sampling", "outputs", "choose")
_FILE_KEYS = ("structure.matrices", "structure.mass", "preload.vector")  # that name files
_RANGE = ("from", "to", "points", "spacing")
DISTRIBUTIONS = {
    "uniform": ("low", "high"),
    "loguniform": ("low", "high"),
    "normal": ("mean", "deviation"),
    "lognormal": ("median", "sigma"),
}
_VARY = (
    *("key", "values", *_RANGE, "distribution"),
    *dict.fromkeys(name for names in DISTRIBUTIONS.values() for name in names),
)
METHODS = ("grid", "list", "sobol", "latin-hypercube", "saltelli")
_MANY = 10**7
_AT_LEAST_ONE = Rule(">= 1", lambda value: 1 <= value <= _MANY)
_AT_LEAST_TWO = between(2, _MANY)


@dataclass(frozen=True)
class Distribution:
    """A distribution of a value, by name and parameters: see `DISTRIBUTIONS`."""

    name: str
    parameters: tuple[float, float]

    def quantile(self, part: Floats) -> Floats:
        """Values below which parts (n,) of it lie."""
        from scipy import stats

        first, second = self.parameters
        frozen: Any = {
            "uniform": lambda: stats.uniform(first, second - first),
            "loguniform": lambda: stats.loguniform(first, second),
            "normal": lambda: stats.norm(first, second),
            "lognormal": lambda: stats.lognorm(second, scale=first),
        }[self.name]
        return np.asarray(frozen().ppf(part), dtype=float)


@dataclass(frozen=True)
class Varied:
    """A key of the scene, and its values one by one or their distribution."""

    key: str
    values: tuple[Any, ...] | Distribution


@dataclass(frozen=True)
class Sampling:
    """How values are combined: a method, and of distributions how many samples, from a seed."""

    method: str
    samples: int
    seed: int


@dataclass(frozen=True)
class Choose:
    """The value of a key for which a quantile of an output is least."""

    key: str
    output: str
    quantile: float


@dataclass(frozen=True)
class Study:
    """A study as its file has it.

    Attributes
    ----------
    title, name : str
    scene : Scene
        With what the study sets, without what it varies.
    content : dict
        The same, as parsed.
    folder : Path
        Where the scene's files are.
    varied : tuple of Varied
    sampling : Sampling
    asked : Asked
    choose : Choose or None
    text : str
        The TOML source.
    """

    title: str
    name: str
    scene: Scene
    content: Content = field(repr=False)
    folder: Path
    varied: tuple[Varied, ...]
    sampling: Sampling
    asked: Asked
    choose: Choose | None
    text: str = field(repr=False)

    __repr__ = short_repr

    @property
    def digest(self) -> str:
        """Return a hash of everything that the results depend on, files of the scene included."""
        plan = (self.varied, self.sampling, self.asked)
        words = [__version__, self.content, repr(plan)]
        found = hashlib.sha256(json.dumps(words, default=str, sort_keys=True).encode())
        for path in self._files():
            found.update(f"{path.name} {path.stat().st_size}".encode())
            with path.open("rb") as file:
                found.update(hashlib.file_digest(file, "sha256").digest())
        return found.hexdigest()[:32]

    def _files(self) -> list[Path]:
        """Return the files that scenes of the study read, in a fixed order."""
        found = []
        for key in _FILE_KEYS:
            names = [get(self.content, key)]
            for each in self.varied:
                if each.key == key and not isinstance(each.values, Distribution):
                    names += each.values
            for name in names:
                if isinstance(name, str):
                    found += source_files(self.folder / name)
        return found


def load_study(path: str | PathLike[str]) -> Study:
    """Read a study; its scene is a shipped one, or a file beside it.

    Raises
    ------
    SlipmodeError
        Naming the file and the key that is refused.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise SlipmodeError(f"{path}: no such study file") from None
    except OSError as error:
        raise SlipmodeError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise SlipmodeError(f"{path}: must be UTF-8 text") from error
    try:
        return _study(text, path)
    except SlipmodeError as error:
        raise SlipmodeError(f"{path}: {error}") from error


def _study(text: str, path: Path) -> Study:
    try:
        root = Table(given := tomllib.loads(text), _TOP)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise SlipmodeError(f"TOML syntax: {' '.join(str(error).split())}") from error
    name = root.text("scene")
    beside = path.parent / name
    original = load_scene(beside if beside.is_file() else name)
    assert original.path is not None  # it was loaded
    content, folder = tomllib.loads(original.text), original.path.parent.resolve()
    content = _set(given.get("set", {}), content)
    scene = read_scene(content, folder, original.text)
    varied = tuple(
        _varied(table, f"vary[{k}]", content)
        for k, table in enumerate(root.sections("vary", _VARY))
    )
    if not varied:
        raise root.error("vary", "nothing varies; give [[vary]] with a key and its values")
    keys = [each.key for each in varied]
    for key in keys:
        if keys.count(key) > 1:
            raise root.error("vary", f"{key!r} is varied twice")
    asked = _asked(root.section("outputs", Asked.KEYS), scene)
    sampling = _sampling(root.section("sampling", ("method", "samples", "seed")), varied)
    choose = None
    if "choose" in root:
        choose = _choose(root.section("choose", ("key", "output", "quantile")), varied, asked)
    title = root.text("title", default=path.stem)
    return Study(
        *(title, path.stem, scene, content, folder, varied, sampling, asked, choose, text)
    )


def _set(values: Any, content: Content) -> Content:
    if not isinstance(values, Mapping):
        raise SlipmodeError('set: must be a table of keys of the scene, "run.step" = 0.1')
    for key, value in values.items():
        if isinstance(value, Mapping):
            raise SlipmodeError(f'set: keys with dots are quoted: "{key}.{next(iter(value), "")}"')
        check_key("set", key, content)
        content = with_value(content, key, value)
    return content


def _varied(table: Table, name: str, content: Content) -> Varied:
    key = table.text("key")
    check_key(f"{name}.key", key, content)
    ways = [way for way in ("values", "from", "distribution") if way in table]
    if len(ways) != 1:
        raise table.error("values", "give one of values, from (to, points), and distribution")
    of = {"values": ("values",), "from": _RANGE}.get(ways[0])
    if of is None:
        distribution = table.choice("distribution", tuple(DISTRIBUTIONS))
        of = ("distribution", *DISTRIBUTIONS[distribution])
    for other in _VARY[1:]:
        if other in table and other not in of:
            raise table.error(other, f"does not go with {ways[0]}; allowed: {', '.join(of)}")
    if ways[0] == "values":
        return Varied(key, _values(table))
    if ways[0] == "from":
        return Varied(key, _range(table))
    return Varied(key, _distribution(table, distribution))


def _values(table: Table) -> tuple[Any, ...]:
    values = table.anything("values")
    if not isinstance(values, list) or not values:
        raise table.error("values", "must be a list of at least one value")
    return tuple(copy.deepcopy(values))


def _range(table: Table) -> tuple[float, ...]:
    first, last = table.number("from"), table.number("to")
    points = table.integer("points", _AT_LEAST_ONE)
    spacing = table.choice("spacing", ("linear", "log"), default="linear")
    if spacing == "log" and not (first > 0.0 and last > 0.0):
        raise table.error("spacing", '"log" needs from > 0 and to > 0')
    space = np.geomspace if spacing == "log" else np.linspace
    return tuple(space(first, last, points).tolist())


def _distribution(table: Table, name: str) -> Distribution:
    first, second = DISTRIBUTIONS[name]
    positive = POSITIVE if name in ("loguniform", "lognormal") else FINITE
    a = table.number(first, positive)
    if second == "high":
        b = table.number(second)
        if b <= a:
            raise table.error(second, f"must be above {first} = {a:g}, got {b:g}")
    else:
        b = table.number(second, POSITIVE)
        if name == "lognormal" and b > log(1e6):
            raise table.error(second, "is the deviation of the logarithm; must be below 13.8")
    return Distribution(name, (a, b))


def _sampling(table: Table, varied: tuple[Varied, ...]) -> Sampling:
    drawn = [each for each in varied if isinstance(each.values, Distribution)]
    method = table.choice("method", METHODS, default="sobol" if drawn else "grid")
    listed = len(drawn) < len(varied)
    if drawn and method in ("grid", "list"):
        raise table.error("method", f'"{method}" needs values; {drawn[0].key} has a distribution')
    if not drawn and method not in ("grid", "list"):
        raise table.error("method", f'"{method}" needs a key with a distribution; or use "grid"')
    if method == "saltelli" and listed:
        raise table.error("method", '"saltelli" needs distributions of all keys')
    for key in ("samples", "seed"):
        if key in table and not drawn:
            raise table.error(key, "goes with distributions; a grid has all its points")
    samples = table.integer("samples", _AT_LEAST_ONE) if drawn else 1
    lengths = [len(each.values) for each in varied if not isinstance(each.values, Distribution)]
    if method == "list" and len(set(lengths)) > 1:
        raise table.error("method", f'"list" needs as many values of each key, got {lengths}')
    size = float(np.prod([samples, *(lengths[:1] if method == "list" else lengths)], dtype=float))
    if size > _MANY:
        raise table.error("samples", f"must be at most 1e7 in all, got {size:g}")
    return Sampling(method, samples, table.integer("seed", default=0))


def _asked(table: Table, scene: Scene) -> Asked:
    modes = MODES[: len(scene.modes.numbers)]

    def mode_of(table: Table, key: str) -> str:
        return table.choice(key, modes)

    resonance: tuple[str, ...] = ()
    if "resonance" in table:
        listed = table.anything("resonance")
        if not isinstance(listed, list) or not listed or not set(map(str, listed)) <= set(modes):
            raise table.error("resonance", f"must be a list of modes of {', '.join(modes)}")
        resonance = tuple(mode for mode in modes if mode in listed)
    curve = None
    if "curve" in table:
        part = table.section("curve", ("mode", "from", "to", "points"))
        curve = Curve(
            mode_of(part, "mode"),
            scene.units.per_frequency * part.number("from", POSITIVE),
            scene.units.per_frequency * part.number("to", POSITIVE),
            part.integer("points", _AT_LEAST_TWO),
        )
    times = table.numbers("times", NON_NEGATIVE) if "times" in table else ()
    if times and max(times) > scene.run.duration:
        raise table.error("times", f"must be at most run.duration = {scene.run.duration:g}")
    asked = Asked(
        steady=table.boolean("steady", default=False),
        resonance=resonance,
        curve=curve,
        peak=table.boolean("peak", default=False),
        times=times,
        recording=table.boolean("recording", default=False),
        dofs=table.integers("dofs") if "dofs" in table else (),
    )
    if not asked.anything:
        raise SlipmodeError(f"outputs: nothing is asked for; give one of {', '.join(Asked.KINDS)}")
    return asked


def _choose(table: Table, varied: tuple[Varied, ...], asked: Asked) -> Choose:
    listed = [each.key for each in varied if not isinstance(each.values, Distribution)]
    if not listed:
        raise table.error("key", "needs a key that is varied by values, and none is")
    key, output = table.choice("key", listed), table.choice("output", asked.chosen_from)
    quantile = table.number("quantile", Rule("0 to 1", lambda q: 0.0 <= q <= 1.0), default=0.95)
    return Choose(key, output, quantile)
