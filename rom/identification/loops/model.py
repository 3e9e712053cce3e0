"""Forces of Jenkins elements in parallel, with limits by direction, a backlash and a spring.

The elements move by u. The backlash of width g is in series with them: with the displacement x,

    u = x - e,   |e| <= g / 2,   e = g / 2 if the elements pull forward, -g / 2 if backward,

so that u stands still while the force of the elements is zero. Element i has the elongation d_i,

    d_i' = u' within -phi_i^- <= d_i <= phi_i^+,    force = sum_i k_i d_i + k_0 (x - middle).

All limits of friction are shares s_i of the limits of both directions: k_i phi_i^+- = s_i F^+-.
Without a backlash, limits by direction are equal limits (F^+ + F^-) / 2 and a constant force.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from slipmode.rom import Iwan
from slipmode.rom.common import Floats

Values = dict[str, float]


class Terms(NamedTuple):
    """Terms of a model: the number of elements, 0 for Iwan's distribution, and others."""

    elements: int = 1
    direction: bool = False
    backlash: bool = False
    spring: bool = False

    def __str__(self) -> str:
        count = {0: "Iwan's distribution", 1: "one Jenkins element"}
        parts = [count.get(self.elements, f"{self.elements} Jenkins elements")]
        parts += [name for name in ("backlash", "spring") if getattr(self, name)]
        if self.direction:
            parts.append("limits by direction")
        return " + ".join(parts)

    def names(self, levels: int) -> tuple[str, ...]:
        """Return the names of the coordinates of a fit; coordinates of each level are last."""
        names = ["stiffness", "chi", "beta"]
        if self.elements:
            numbers = range(1, self.elements + 1)
            names = [f"stiffness_{i}" for i in numbers] + [f"weight_{i}" for i in numbers[1:]]
        names += ["spring"] if self.spring else []
        own = ["backlash"] if self.backlash else []
        own += ["forward", "backward"] if self.direction else ["limit"]
        return (*names, *(f"{level}.{each}" for level in range(levels) for each in own))

    def larger(self, values: Values, reach: float) -> Iterator[tuple[Terms, Values]]:
        """Yield models with a term more, and initial values of their coordinates.

        `values` belong to this model, `reach` [m] is the largest displacement.
        """
        total = float(self.sliders(values)[0].sum())
        if not self.direction:
            both = {
                f"{name.partition('.')[0]}.{way}": value
                for name, value in values.items()
                if name.endswith(".limit")
                for way in ("forward", "backward")
            }
            yield self._replace(direction=True), values | both
        if not self.backlash:
            levels = {name.partition(".")[0] for name in values if "." in name}
            for share in (0.05, 0.3):
                widths = {f"{level}.backlash": share * reach for level in levels}
                yield self._replace(backlash=True), values | widths
        if not self.spring:
            yield self._replace(spring=True), values | {"spring": 0.02 * total}
        if not self.elements:
            return
        if self.elements > 1:
            values = values | {"stiffness": total, "chi": 0.5, "beta": 1.0}
            yield self._replace(elements=0), values
        for share in (0.2, 2.0):
            n = self.elements + 1
            new = {f"stiffness_{n}": share * total, f"weight_{n}": 0.5}
            yield self._replace(elements=n), values | new

    def sliders(self, values: Mapping[str, float]) -> tuple[Floats, Floats]:
        """Return stiffness [N/m] and share of the limit of each element, in the order of slip."""
        if not self.elements:
            limit, k = self.iwan(values, 1.0).distribution()
            return k, limit
        numbers = range(1, self.elements + 1)
        k = np.array([values[f"stiffness_{i}"] for i in numbers])
        weight = np.array([1.0, *(values[f"weight_{i}"] for i in numbers[1:])])
        share = weight / weight.sum()
        order = np.argsort(share / k)
        return k[order], share[order]

    def iwan(self, values: Mapping[str, float], limit: float) -> Iwan:
        """Return Iwan's distribution with a limit [N]. The coordinate `chi` is 1 + chi."""
        chi = min(values["chi"] - 1.0, Iwan.LARGEST_CHI)
        return Iwan(limit, values["stiffness"], chi, values["beta"])


class Joints(NamedTuple):
    """A model of one level, with several sets of values: variants.

    Attributes
    ----------
    stiffness, low, high : (variants, elements) ndarray
        k_i [N/m], -phi_i^- and phi_i^+ [m].
    backlash, spring : (variants,) ndarray
        g [m], k_0 [N/m].
    middle : float
        Displacement without force of the spring [m].
    """

    stiffness: Floats
    low: Floats
    high: Floats
    backlash: Floats
    spring: Floats
    middle: float

    def forces(self, strokes: Sequence[Floats]) -> Floats:
        """Return the forces (variants, samples) [N] along strokes that follow each other.

        `strokes` are displacements [m]. At the start the elements have no force, and the backlash
        is in its middle.
        """
        d, e = np.zeros_like(self.stiffness), np.zeros_like(self.backlash)
        made = []
        for x in strokes:
            # Backward strokes are forward strokes of the mirrored joint.
            sign = 1.0 if x[-1] > x[0] else -1.0
            low, high = (self.low, self.high) if sign > 0.0 else (-self.high, -self.low)
            travel = sign * (x - x[0])
            u, slack = self._through_backlash(travel, sign * d, high, sign * e)
            elongation = (sign * d)[..., np.newaxis] + u[:, np.newaxis]
            np.clip(elongation, low[..., np.newaxis], high[..., np.newaxis], out=elongation)
            force = (self.stiffness[:, np.newaxis] @ elongation)[:, 0]
            made.append(sign * force + np.multiply.outer(self.spring, x - self.middle))
            d, e = sign * elongation[..., -1], sign * slack
        return np.concatenate(made, axis=1)

    def _through_backlash(
        self, travel: Floats, d: Floats, high: Floats, e: Floats
    ) -> tuple[Floats, Floats]:
        """Return u (variants, samples) along a forward stroke, and e (variants,) at its end."""
        if not self.backlash.any():
            return np.tile(travel, (len(e), 1)), e
        released = self._unloading(d, high)[:, np.newaxis]
        beyond, rest = travel - released, (0.5 * self.backlash - e)[:, np.newaxis]
        u = np.where(beyond <= 0.0, travel, released + np.maximum(beyond - rest, 0.0))
        return u, e + np.clip(beyond[:, -1:], 0.0, rest)[:, 0]

    def _unloading(self, d: Floats, high: Floats) -> Floats:
        """Return the forward motion (variants,) after which the elements do not pull backward."""
        # Their force is linear between the motions at which one more element slips.
        motion = np.sort(np.maximum(high - d, 0.0), axis=1)
        motion = np.concatenate([np.zeros((len(d), 1)), motion], axis=1)
        at_slip = np.minimum(d[..., np.newaxis] + motion[:, np.newaxis], high[..., np.newaxis])
        force = (self.stiffness[:, np.newaxis] @ at_slip)[:, 0]
        return np.array([np.interp(0.0, f, u) for f, u in zip(force, motion, strict=True)])
