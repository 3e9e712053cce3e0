"""What a friction table is worth."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Accuracy:
    """What the table was measured to be worth, relative to the largest |S_j|.

    Attributes
    ----------
    tolerance : float
        What was asked for.
    interpolation : float
        Largest error between the nodes, from those found at points where most is expected; half
        the tolerance if that is more, for less is not looked for. Above the tolerance where
        friction jumps: contacts have two motions there, or none that repeats.
    resolution : float
        Change on doubling steps and lines of the contact problem.
    periodicity : float
        Largest distance from a periodic contact motion.
    neglected_response : float
        Largest contact motion due to the response of modes to one higher-order harmonic that the
        table leaves out, relative to the motion without friction. 0 if the table has every
        harmonic that counts; infinity if it could not be measured, because the contact motion
        converges at none of the amplitudes that are tried.
    detuning : float or None
        Error of forcing 5 % from the carriers, the largest of what was tried.
        It grows with the square of that distance where the table has dS_j / dOmega_k, else in
        proportion. 0 in the paper's formulation, which has no other frequencies. None where
        friction was not to follow them, and nothing was tried.
    steps, lines : int
        Discretisation of the torus.
    solved : int
        Contact problems solved for the nodes and for measuring the interpolation.
    """

    tolerance: float
    interpolation: float
    resolution: float
    periodicity: float
    neglected_response: float
    detuning: float | None
    steps: int
    lines: int
    solved: int
