"""Contact laws of a structure from measured backbones."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import field
from itertools import compress
from typing import Literal, NamedTuple, get_args

import numpy as np
import scipy

from slipmode.rom import Contacts, Model, Reduced, SlipmodeError, Structure
from slipmode.rom.common import Finding, Floats, frozen, in_one_line, naming, percentage, warn
from slipmode.rom.identification.contacts.data import measured_points
from slipmode.rom.identification.contacts.groups import ContactGroups, GroupLaw, parameter_value
from slipmode.rom.identification.contacts.posterior import (
    LINEAR,
    Fit,
    Minimum,
    Posterior,
    profile_end,
)
from slipmode.rom.identification.contacts.problem import FitProblem, Tables, check_structure
from slipmode.rom.identification.models.identified import IdentifiedBackbone

Adjusted = Literal["damping", "frequency"]

_MOST_TABLES = 8  # per mode
# Change of the parameters by the next correction, in their deviations, at which a fit ends
_CONVERGED = 0.2
_MISFIT = 3.0  # residual in deviations from which the laws do not describe the data


@frozen
class ContactFit:
    """Hold contact laws that were fitted to backbones.

    Attributes
    ----------
    laws : dict of str to contact law
        Law of each group.
    law : Contacts
        Laws at their contact DOFs, for `rom.tabulate`.
    parameters : dict of str to float
        Value of each fitted parameter. GROUP.PARAMETER are parameters of the laws. "mode
        N.damping" is the damping ratio of a mode without friction. "mode N.frequency" is its
        natural frequency with stuck contacts, relative to the structure.
    interval : dict of str to (float, float)
        95 % interval of each parameter.
    identified, unidentified : tuple of str
        Parameters whose interval is narrower than a factor of 4, and all others.
    combinations : dict of str to (float, float)
        95 % intervals of products of powers of unidentified parameters that the data determine.
    undetermined : tuple of str
        Products of powers of unidentified parameters that the data do not determine.
    misfit : float
        Root mean square of the residuals, relative to the standard deviations of the data [-].
    closed_form_error : float
        Largest relative error of the damping by describing functions, compared with friction
        tables [-]. The fit is corrected for it.
    models : dict of int to Model
        Model of each mode alone, up to its largest measured amplitude.
    source : FitSource
        Data from which further results are computed.
    """

    laws: dict[str, GroupLaw]
    law: Contacts
    parameters: dict[str, float]
    interval: dict[str, tuple[float, float]]
    identified: tuple[str, ...]
    unidentified: tuple[str, ...]
    combinations: dict[str, tuple[float, float]]
    undetermined: tuple[str, ...]
    misfit: float
    closed_form_error: float
    models: dict[int, Model]
    source: FitSource = field(repr=False)

    def backbone(self, mode: int) -> IdentifiedBackbone:
        """Return the fitted frequency and damping at the measured amplitudes.

        They are computed with the friction table of the mode.

        Parameters
        ----------
        mode : int
            Number of a measured mode.

        Returns
        -------
        IdentifiedBackbone
            Amplitudes are displacements of the sensor [m]. Standard deviations are taken
            from the data.

        Raises
        ------
        SlipmodeError
            If there is no backbone of this mode.
        """
        problem = self.source.problem
        if mode not in problem.points:
            raise SlipmodeError(
                f"mode = {in_one_line(mode)}: must be one of {', '.join(map(str, problem.points))}"
            )
        points = problem.points[mode]
        return IdentifiedBackbone(
            mode=mode,
            amplitude=points.displacement,
            frequency=self.source.tables.values[mode][0],
            damping=self.source.tables.values[mode][1],
            frequency_deviation=points.deviation[0],
            damping_deviation=points.deviation[1],
            unit="m",
            steady=points.steady,
        )

    def reduced(self, *modes: int) -> Reduced:
        """Return the structure reduced to measured modes, for `rom.tabulate` with `law`.

        Parameters
        ----------
        *modes : int
            Numbers of one or two measured modes.

        Returns
        -------
        Reduced
            Reduced structure with the fitted damping and frequency of these modes.

        Raises
        ------
        SlipmodeError
            If a mode was not measured.
        """
        problem, unknowns = self.source.problem, self.source.unknowns
        if not modes or not set(modes) <= set(problem.points):
            raise SlipmodeError(
                f"modes = {in_one_line(modes)}: must be one or two of "
                f"{', '.join(map(str, problem.points))}"
            )
        return problem.adjusted(problem.reduced(unknowns, modes), unknowns)


@frozen
class FitSource:
    """What the results of a fit are computed from."""

    problem: FitProblem
    unknowns: Floats  # (names,), logarithms
    tables: Tables


def fit_contacts(
    structure: Structure,
    backbones: Mapping[int, IdentifiedBackbone],
    groups: Mapping[str, tuple[GroupLaw, Sequence[int]]],
    *,
    sensor: int,
    fixed: Sequence[str] = (),
    adjust: Sequence[Adjusted] = (),
) -> ContactFit:
    """Return contact laws of a structure fitted to measured backbones.

    A backbone is the frequency and the damping of a mode against its amplitude.

    Parameters
    ----------
    structure : Structure
        Structure with its contact DOFs.
    backbones : {mode: IdentifiedBackbone}
        Measured backbones by the number of the mode with stuck contacts, from `rom.identify`,
        `rom.identify_sine` or arrays. All other modes are assumed to be at rest.
    groups : {name: (law, contact DOFs)}
        Groups of contacts with a common law, Jenkins or Iwan. The parameters of the law are
        initial guesses, which should be within a factor of 3.
    sensor : int
        DOF at which the amplitudes were measured.
    fixed : sequence of str
        Parameters that keep their values, such as "left.stiffness" of the group "left".
    adjust : sequence of {"damping", "frequency"}
        Linear properties of the modes that are fitted as well: the damping ratio without friction
        and the natural frequency with stuck contacts. Default: the values of the structure. With
        "frequency", only changes of the frequency, and damping, determine stiffnesses.

    Returns
    -------
    ContactFit
        Laws with intervals, and the combinations of parameters that the data determine.

    Raises
    ------
    SlipmodeError
        If an argument is not allowed, there are fewer data than parameters, or the fit does not
        converge.

    Warns
    -----
    ValidityWarning
        If the misfit is above 3 standard deviations.

    Notes
    -----
    The logarithms of the parameters are fitted by least squares, weighted by the deviations of the
    backbones. Describing functions of the contacts give frequency and damping, with the coupling
    between contacts and without higher harmonics. The difference from a friction table at the
    optimum is then added. The fit is repeated until the parameters change by less than 0.2
    standard deviations. This correction changes the damping by up to 0.6 % for contacts with
    0.5 % of the stiffness of a mode. For contacts with 4 % it is up to 10 %. Stronger contacts are
    refused if the fit does not converge (tests/rom/identification/test_contacts.py).

    The initial guess has a prior standard deviation of a factor of 10: parameters that the data do
    not determine keep it. Intervals follow from Laplace's approximation in logarithms. Intervals
    wider than +-10 % follow from the profile, the least sum of squares with this parameter fixed.
    The covariance of the data is the scatter between records plus the squares of the deviations.
    It is multiplied by the square of the misfit if the misfit is above 1. Backbones of several
    modes are assumed to be independent.
    """
    if unknown := [each for each in adjust if each not in get_args(Adjusted)]:
        raise SlipmodeError(f"adjust = {in_one_line(unknown[0])}: must be damping or frequency")
    check_structure(structure)
    if not isinstance(sensor, int | np.integer) or not 0 <= sensor < structure.n_dofs:
        raise SlipmodeError(
            f"sensor = {in_one_line(sensor)}: must be a DOF, 0 to {structure.n_dofs - 1}"
        )
    problem = FitProblem(
        structure,
        sensor,
        ContactGroups.of(groups, fixed),
        tuple(dict.fromkeys(adjust)),
        measured_points(backbones),
    )
    data = sum(points.values.size for points in problem.points.values())
    if not problem.names or data <= len(problem.names):
        raise SlipmodeError(
            f"backbones: {data} values do not determine {len(problem.names)} parameters; there "
            "must be more values than parameters, and at least one parameter"
        )
    return _result(problem, _optimum(problem))


class _Optimum(NamedTuple):
    """Unknowns with the least sum of squares, and the problem around them."""

    minimum: Minimum
    misfit: float
    jacobian: Floats
    tables: Tables
    fit: Fit


def _optimum(problem: FitProblem) -> _Optimum:
    _, forms = problem.reductions(problem.initial)
    none = np.zeros(len(problem.names), dtype=bool)
    fit = problem.fit(forms)
    fitted = [fit(each, none) for each in problem.starts(forms)]
    unknowns = min(fitted, key=lambda each: each.cost).x
    for _ in range(_MOST_TABLES):
        reductions, forms = problem.reductions(unknowns)
        with warnings.catch_warnings(record=True) as caught, naming("fitted laws"):
            warnings.simplefilter("always")  # those of the last tables are passed on
            tables = problem.tables(reductions, forms, unknowns)
        residuals = problem.stacked(tables.values, unknowns)
        closed = problem.residuals(forms, unknowns[np.newaxis])[0]
        fit = problem.fit(forms, residuals - closed)
        J = problem.jacobian(forms, unknowns)
        following = fit(unknowns, none).x
        if np.linalg.norm(J @ (following - unknowns)) <= _CONVERGED:
            for each in caught:
                warnings.warn(each.message, each.category, stacklevel=3)
            of_data = residuals[: -unknowns.size]  # without those of the initial values
            misfit = float(np.sqrt(of_data @ of_data / (of_data.size - unknowns.size)))
            minimum = Minimum(unknowns, 0.5 * float(residuals @ residuals))
            return _Optimum(minimum, misfit, J, tables, fit)
        unknowns = following
    raise SlipmodeError(
        "groups: the fit does not converge, because harmonics of the contacts change the "
        "backbones strongly. The relative error of damping by describing functions is "
        f"{percentage(tables.closed_form_error)}; give other initial laws or smaller amplitudes"
    )


def _result(problem: FitProblem, optimum: _Optimum) -> ContactFit:
    x, misfit = optimum.minimum.x, optimum.misfit
    if misfit > _MISFIT:
        reason = (
            f"the rms residual is {misfit:.1f} standard deviations of the data. Check sensor and "
            "groups, fit linear properties too (adjust), or begin with other laws"
        )
        warn([Finding("contact laws", "do not fit the data", reason, "warning")], stacklevel=4)
    posterior = _posterior(problem, optimum)
    names = problem.names
    values, low, high = (
        [float(parameter_value(name, each)) for name, each in zip(names, logarithms, strict=True)]
        for logarithms in (x, *posterior.interval)
    )
    unidentified = tuple(compress(names, posterior.is_open))
    determined, undetermined = posterior.combinations()
    return ContactFit(
        laws=problem.groups.laws(x[: len(problem.groups.names)]),
        law=problem.law(x),
        parameters=dict(zip(names, values, strict=True)),
        interval=dict(zip(names, zip(low, high, strict=True), strict=True)),
        identified=tuple(name for name in names if name not in unidentified),
        unidentified=unidentified,
        combinations=determined,
        undetermined=undetermined,
        misfit=misfit,
        closed_form_error=optimum.tables.closed_form_error,
        models=optimum.tables.models,
        source=FitSource(problem, x, optimum.tables),
    )


def _posterior(problem: FitProblem, optimum: _Optimum) -> Posterior:
    records = [points.records for points in problem.points.values() if points.records]
    quantile = float(scipy.special.stdtrit(min(records, default=np.inf) - 1, 0.975))
    quantile *= max(optimum.misfit, 1.0)
    x, J = optimum.minimum.x, optimum.jacobian
    covariance = np.asarray(np.linalg.inv(J.T @ J), dtype=float)
    half = quantile * np.sqrt(np.diag(covariance))
    interval = np.stack((x - half, x + half))
    for k in np.flatnonzero(half > LINEAR).tolist():
        slope, step = covariance[k] / covariance[k, k], min(half[k], 1.0)
        interval[:, k] = [
            profile_end(optimum.fit, optimum.minimum, slope, k, each, quantile**2)
            for each in (-step, step)
        ]
    return Posterior(problem.names, x, covariance, interval, quantile)
