"""Stated errors against true ones on drawn structures: `make bench-errors`.

Arguments: the number of structures, the kinds of answers (default: all), `--first SEED`.
"""

import argparse
import time

import numpy as np

from evidence.answers import KINDS, NO_ORACLE, REFUSALS, Answer

LARGE = 1e-4  # true errors whose stated ones are to inform


def measure(kind: str, seeds: range) -> str:
    """Print a line for each structure; return the line of the kind."""
    answer, drawn = KINDS[kind]
    found: list[tuple[int, Answer]] = []
    refused = unknown = 0
    for seed in seeds:
        given, begin = drawn(seed), time.process_time()
        try:
            answers = answer(given)
        except REFUSALS as reason:
            refused += 1
            print(
                f"{kind} {given.name}: refused: {' '.join(str(reason).split())[:160]}", flush=True
            )
            continue
        except NO_ORACLE as reason:
            unknown += 1
            print(f"{kind} {given.name}: not compared: {reason}", flush=True)
            continue
        found += [(seed, each) for each in answers]
        worst = max(answers, key=lambda each: (each.true - each.own) / max(each.stated, 1e-300))
        print(
            f"{kind} {given.name}: true {worst.true:.2e}, stated {worst.stated:.2e}, oracle "
            f"{worst.own:.0e} ({worst.what}; {sum(each.violated for each in answers)} of "
            f"{len(answers)} violated), {time.process_time() - begin:.0f} CPU s",
            flush=True,
        )
    violations = [(seed, each) for seed, each in found if each.violated]
    large = [each for _, each in found if each.true > max(LARGE, each.own)]
    median = np.median([each.stated / each.true for each in large]) if large else np.nan
    line = f"{kind:9} {len(found):7} {refused:7} {unknown:9} {len(violations):10} {median:13.2g}"
    if violations:
        seed, worst = max(violations, key=lambda pair: pair[1].true / max(pair[1].stated, 1e-300))
        line += f"  {worst.true / max(worst.stated, 1e-300):.3g} (seed {seed}, {worst.what})"
    return line


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("structures", type=int, nargs="?", default=8)
    parser.add_argument("kinds", nargs="*", default=list(KINDS))
    parser.add_argument("--first", type=int, default=0)
    given = parser.parse_args()
    seeds = range(given.first, given.first + given.structures)
    lines = [measure(kind, seeds) for kind in given.kinds]
    print("kind      answers refused no oracle violations stated / true  worst true / stated")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
