"""Rayleigh damping, from two coefficients, damping ratios or a loss factor; structural damping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from slipmode.rom.arrays import as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.representable import ALLOWED, fits


@dataclass(frozen=True)
class Rayleigh:
    """Describe proportional damping C = alpha M + beta K.

    At the angular frequency omega the damping ratio is (alpha / omega + beta omega) / 2.

    Parameters
    ----------
    alpha : float
        Factor of the mass matrix [1/s], >= 0.
    beta : float
        Factor of the stiffness matrix [s], >= 0.

    Raises
    ------
    SlipmodeError
        If a factor is negative or not finite.
    """

    alpha: float
    beta: float

    def __post_init__(self) -> None:
        for name, value in (("alpha", self.alpha), ("beta", self.beta)):
            if not (as_floats(f"damping: {name}", value) >= 0.0 and fits(value)):
                raise SlipmodeError(
                    f"damping: {name} must be a finite number >= 0, {ALLOWED}, got {value}"
                )

    @classmethod
    def from_ratios(
        cls, ratio: float | Sequence[float], frequency: float | Sequence[float]
    ) -> Self:
        """Return Rayleigh damping with given damping ratios at one or two frequencies.

        Parameters
        ----------
        ratio : float or sequence of one or two float
            Damping ratios [-], >= 0, one for each frequency.
        frequency : float or sequence of one or two float
            Frequencies [rad/s], > 0. One frequency gives C = beta K.

        Returns
        -------
        Rayleigh
            Damping with these ratios at these frequencies.

        Raises
        ------
        SlipmodeError
            If no alpha, beta >= 0 have these ratios. Two ratios may differ at most by the quotient
            of the two frequencies.

        Examples
        --------
        >>> rom.Rayleigh.from_ratios(0.01, 400.0)
        Rayleigh(alpha=0.0, beta=5e-05)
        """
        given = {"ratio": ratio, "frequency": frequency}
        zeta, omega = (np.atleast_1d(as_floats(key, value)) for key, value in given.items())
        if zeta.shape not in ((1,), (2,)) or zeta.shape != omega.shape:
            raise SlipmodeError(
                f"ratio, frequency: must have one or two values each, got {ratio} and {frequency}"
            )
        if not (np.all(zeta >= 0.0) and np.all(omega > 0.0) and fits(zeta) and fits(omega)):
            raise SlipmodeError(
                f"ratio, frequency: must be >= 0 and > 0, got {ratio} and {frequency}"
            )
        if zeta.size == 1:
            return cls(0.0, float(2.0 * zeta[0] / omega[0]))
        if omega[0] == omega[1]:
            raise SlipmodeError(f"frequency: must be two different frequencies, got {frequency}")
        rows = 0.5 * np.stack((1.0 / omega, omega), axis=1)
        alpha, beta = np.linalg.solve(rows, zeta).tolist()
        if alpha < 0.0 or beta < 0.0:
            quotient = float(omega.max() / omega.min())
            raise SlipmodeError(
                "ratio: with alpha M + beta K the ratios differ at most by a factor of "
                f"{quotient:.3g} at these frequencies, got {ratio}; give a damping matrix"
            )
        return cls(alpha, beta)

    @classmethod
    def from_loss_factor(cls, loss_factor: float, frequency: float | Sequence[float]) -> Self:
        """Return Rayleigh damping equivalent to a hysteretic loss factor.

        At resonance, the complex stiffness K (1 + i eta) dissipates as much energy per cycle as
        the damping ratio eta / 2.

        Parameters
        ----------
        loss_factor : float
            Loss factor eta [-], >= 0.
        frequency : float or sequence of one or two float
            Frequencies [rad/s] at which the dissipation is exact, for instance the frequencies of
            the retained modes.

        Returns
        -------
        Rayleigh
            Damping with the ratio eta / 2 at these frequencies.

        Raises
        ------
        SlipmodeError
            If the frequencies are equal or not positive, or the loss factor is negative.
        """
        return cls.from_ratios([0.5 * loss_factor] * np.size(frequency), frequency)


@dataclass(frozen=True)
class LossFactor:
    """Describe structural (hysteretic) damping K (1 + i eta).

    In steady states the damping is exact at the carrier. Other modes have the damping ratio
    eta / 2 at their natural frequencies, see `Structure`.

    Parameters
    ----------
    eta : float
        Loss factor of the whole structure [-], >= 0. The contacts have none.

    Raises
    ------
    SlipmodeError
        If the loss factor is negative or not finite.

    Examples
    --------
    >>> rom.Structure([[1.0]], [[4.0]], rom.LossFactor(0.02), contact=[0])
    Structure(1 DOFs, 1 contacts, dense)
    """

    eta: float

    def __post_init__(self) -> None:
        if not (as_floats("damping: eta", self.eta) >= 0.0 and fits(self.eta)):
            raise SlipmodeError(
                f"damping: eta must be a finite number >= 0, {ALLOWED}, got {self.eta}"
            )
