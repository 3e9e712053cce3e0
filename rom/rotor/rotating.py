"""A rotating structure: matrices that depend on the rotor speed, and its modes over speeds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import numpy as np

from slipmode.rom.arrays import as_floats, as_number, check_count, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.rotor.speed_modes import ModesAtSpeed, SpeedModes, follow
from slipmode.rom.structure.held import Held, bonded, stuck
from slipmode.rom.structure.matrices import MatrixLike, as_skew, as_symmetric, projection
from slipmode.rom.structure.structure import Structure

# More modes of each speed than are followed, because modes may change places.
_OTHERS = 8


class RotatingStructure:
    """Represent a structure in the frame of a rotor, at any constant rotor speed.

    At the speed n [rad/s] the equation of motion is M x'' + (C + n G) x' + (K_0 + n^2 K_1) x +
    W g = f. Circulatory forces, which a skew-symmetric stiffness describes, are refused.

    Parameters
    ----------
    structure : Structure
        Structure at rest, with M, C, K_0 and W. C does not depend on the speed.
    spin_stiffness : (n, n) array or sparse matrix
        K_1 [kg]: stress stiffening by centrifugal load, less spin softening, per squared speed;
        symmetric.
    gyroscopic : (n, n) array or sparse matrix, optional
        G [kg]: gyroscopic or Coriolis forces per speed; skew-symmetric. Default: none.

    Attributes
    ----------
    structure : Structure
        Structure at rest.
    spin_stiffness, gyroscopic : (n, n) matrix
        K_1 and G [kg]; G is None if it was left out.

    Raises
    ------
    SlipmodeError
        If K_1 is not symmetric, G is not skew-symmetric, or a size differs from the structure.

    Examples
    --------
    A mass on a radial spring loses stiffness by spin softening:

    >>> mass = rom.Structure([[1.0]], [[4.0]], contact=[0])
    >>> rotor = rom.RotatingStructure(mass, [[-1.0]])
    >>> rotor.modes([0.0, 1.0], rom.Jenkins(1.0, 12.0), 1).frequency.round(3).T
    array([[4.   , 3.873]])
    """

    def __init__(
        self,
        structure: Structure,
        spin_stiffness: MatrixLike,
        gyroscopic: MatrixLike | None = None,
    ) -> None:
        self.structure = structure
        self.spin_stiffness = as_symmetric("spin_stiffness", spin_stiffness, structure.n_dofs)
        n = structure.n_dofs
        self.gyroscopic = None if gyroscopic is None else as_skew("gyroscopic", gyroscopic, n)

    def __repr__(self) -> str:
        forces = "" if self.gyroscopic is None else ", gyroscopic"
        return f"RotatingStructure({self.structure!r}{forces})"

    @classmethod
    def from_speeds(
        cls,
        structure: Structure,
        spinning: Structure,
        speed: float,
        gyroscopic: MatrixLike | None = None,
    ) -> Self:
        """Return the rotor of two exports of a finite element program.

        Parameters
        ----------
        structure : Structure
            Structure at rest.
        spinning : Structure
            The same structure, with the prestress and the spin softening of a rotor speed.
        speed : float
            Rotor speed of `spinning` [rad/s], > 0.
        gyroscopic : (n, n) array or sparse matrix, optional
            G [kg], see the class.

        Returns
        -------
        RotatingStructure
            Rotor with K_1 = (K - K_0) / speed^2.

        Raises
        ------
        SlipmodeError
            If the speed is not positive, or the structures differ in size.
        """
        if not 0.0 < as_number("speed", speed) < np.inf:
            raise SlipmodeError(f"speed: must be a finite number > 0 rad/s, got {speed}")
        if spinning.n_dofs != structure.n_dofs:
            raise SlipmodeError(
                f"spinning: must have {structure.n_dofs} DOFs, like structure, got "
                f"{spinning.n_dofs}"
            )
        change: Any = spinning.stiffness - structure.stiffness
        return cls(structure, change / speed**2, gyroscopic)

    def at_speed(self, speed: float) -> Structure:
        """Return the structure at a constant rotor speed, without gyroscopic forces.

        Parameters
        ----------
        speed : float
            Rotor speed n [rad/s].

        Returns
        -------
        Structure
            Structure with K_0 + n^2 K_1, and M, C and W of the structure at rest.
        """
        rest, square = self.structure, as_number("speed", speed) ** 2
        if not np.isfinite(square):
            raise SlipmodeError(f"speed: must be finite, got {speed} rad/s")
        loss: Any = 0.0 if rest.loss is None else 1j * rest.loss
        return Structure(
            rest.mass,
            rest.stiffness + square * self.spin_stiffness + loss,
            0.0 if rest.beta == 0.0 else rest.damping,
            contact=rest.directions,
            labels=rest.labels,
        )

    def modes(self, speeds: Sequence[float], law: Elastic | None = None, n: int = 4) -> SpeedModes:
        """Return the modes with stuck contacts over rotor speeds, each followed by its shape.

        Parameters
        ----------
        speeds : sequence of float
            Rotor speeds [rad/s], ascending.
        law : elastic law, optional
            Law whose springs are the stuck contacts. Default: bonded contacts.
        n : int, default 4
            Number of modes: the lowest ones at the first speed.

        Returns
        -------
        SpeedModes
            Frequencies and shapes, with gyroscopic forces.

        Raises
        ------
        SlipmodeError
            If the speeds are not ascending, the structure has no positive stiffness at a speed, or
            a shape changes so much between two speeds that its mode cannot be followed. Modes of
            equal frequencies at rest, which gyroscopic forces mix, are followed from above 0.
        """
        given = as_floats("speeds", speeds)
        if given.ndim != 1 or not given.size or not np.all(np.diff(given) > 0.0):
            raise SlipmodeError(f"speeds: must be ascending [rad/s], got {in_one_line(speeds)}")
        check_count("n", n)
        if law is not None and not isinstance(law, Elastic):
            raise SlipmodeError("law: must be an elastic law; leave it out for rigid friction")
        every = [self._modes_at(speed, law, n + _OTHERS) for speed in given.tolist()]
        return follow(given, every, self.structure.mass, n)

    def _modes_at(self, speed: float, law: Elastic | None, count: int) -> ModesAtSpeed:
        """Return frequencies and shapes of the lowest modes at a speed."""
        try:
            structure = self.at_speed(speed)
            omega, shapes = _held(structure, law).modes(count)
        except SlipmodeError as error:
            raise SlipmodeError(
                f"speeds: at {speed:g} rad/s, {error} (spin softening may exceed the stiffness)"
            ) from None
        if self.gyroscopic is None:
            return omega, shapes
        # q'' + n G q' + omega^2 q = 0 for the modes without G; its solutions are exp(i nu t)
        G = speed * projection(shapes, self.gyroscopic, shapes)
        zero, unit = np.zeros((omega.size, omega.size)), np.eye(omega.size)
        exponent, found = np.linalg.eig(np.block([[zero, unit], [-np.diag(omega**2), -G]]))
        upper = np.argsort(exponent.imag)[omega.size :]
        q = found[: omega.size, upper]
        return exponent.imag[upper], shapes @ (q / np.linalg.norm(q, axis=0))


def _held(structure: Structure, law: Elastic | None) -> Held:
    """Return the structure with stuck contacts: springs of a law, or bonds."""
    if law is None:
        return bonded(structure)
    return stuck(structure, law.elements(structure.n_contacts).reference)
