"""Flutter that friction holds: amplitude and frequency over the aerodynamic coefficient.

Where the flow puts in more than friction can ever take, the two branches meet and there is no
limit cycle any more. Between them the blade settles on the stable one; a gust that lifts it past
the unstable one sets it free.
"""

from slipmode import rom


def branches(coefficients: list[complex]) -> list[tuple[rom.LimitCycle, ...]]:
    """Limit cycles at each aerodynamic coefficient [rad^2/s^2], by ascending amplitude."""
    structure = rom.two_mass(beta=0.01)
    found = []
    for coefficient in coefficients:
        reduced = rom.reduce(structure, modes=(0,), aerodynamics=(coefficient,))
        model = rom.tabulate(reduced, rom.Coulomb(limit=2.0), amplitude=(8.0,))
        found.append(rom.limit_cycles(model))
    return found


if __name__ == "__main__":
    coefficients = [-0.015j, -0.02j, -0.022j, -0.03j]
    for coefficient, cycles in zip(coefficients, branches(coefficients), strict=True):
        for cycle in cycles:
            (amplitude,), (frequency,) = abs(cycle.amplitude), cycle.frequency
            kind = "stable" if cycle.stable else "unstable"
            print(f"{coefficient:.3g}: {kind} at |a| = {amplitude:.4f}, {frequency:.5f} rad/s")
        if not cycles:
            print(f"{coefficient:.3g}: friction does not hold it")
