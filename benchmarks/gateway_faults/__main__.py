"""Play the episodes and print what came of them."""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

import benchmarks.gateway_faults.old  # noqa: F401  (registers its classes)
from benchmarks.gateway_faults.classes import FAULTS, MASQUERADE, cycles
from benchmarks.gateway_faults.harness import Episode, Outcome
from benchmarks.gateway_faults.states import RESTARTS
from gateway.database import Database
from gateway.mapping import read_database
from gateway.node import GatewaySettings

ON_THE_MACHINES_CLOCK = ("gateway stopped, then goes on", "machine's clock stands, step 0")
HEAD = f"{'':52}{'episodes':>9}{'noticed':>9}{'answers':>9}{'unsafe':>8}{'valid again':>13}"
Play = Callable[[Database, np.random.Generator], Outcome]


def plays() -> Iterator[tuple[str, Play]]:
    """Yield every class of faults: its name, and what plays an episode of it."""
    for name, fault in FAULTS.items():
        yield name, partial(_play, fault=fault)
    machine = GatewaySettings(machine_clock=True)
    for name in ON_THE_MACHINES_CLOCK:
        yield f"{name} (--clock machine)", partial(_play, fault=FAULTS[name], settings=machine)
    yield from RESTARTS.items()


def _play(
    database: Database,
    rng: np.random.Generator,
    fault: Callable[[Episode], None],
    settings: GatewaySettings | None = None,
) -> Outcome:
    episode = Episode(database, rng, settings)
    episode.settle()
    fault(episode)
    return episode.finish()


def _nothing(episode: Episode) -> None:
    """Let nothing go wrong."""
    for _ in cycles(episode):
        episode.cycle()


def availability(quiet: list[Outcome], faulty: list[Outcome]) -> str:
    """Return how often answers are valid without a fault, and how soon again after one."""
    answers, valid = (sum(getattr(one, name) for one in quiet) for name in ("answers", "valid"))
    back = sorted(one.back_s for one in faulty if one.noticed and one.again)
    most = back[math.ceil(0.99 * len(back)) - 1]
    share = 100.0 * valid / answers
    return (
        f"without a fault {valid:,} of {answers:,} answers are valid ({share:.1f} %)\n"
        f"after a fault that was noticed they are valid again within {most:.2f} s in 99 % of "
        f"{len(back):,} episodes, {back[-1]:.2f} s at most"
    )


def row(name: str, outcomes: list[Outcome]) -> str:
    """Return a line of the table."""
    counted = ("noticed", "answers", "unsafe", "again")
    noticed, answers, unsafe, again = (sum(getattr(o, of) for o in outcomes) for of in counted)
    return f"{name:52}{len(outcomes):9,}{noticed:9,}{answers:9,}{unsafe:8,}{again:13,}"


def main() -> int:
    """Play, print, and return 1 if anything unsafe was called valid."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--episodes", type=int, default=20, help="of each class (20)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--without-proof", action="store_true", help="a machine that cannot prove its cycles"
    )
    args = parser.parse_args()
    database = read_database()
    database = database.unproven() if args.without_proof else database
    begun = time.monotonic()

    def played(play: Play, number: int) -> list[Outcome]:
        rng = np.random.default_rng([args.seed, number])
        return [play(database, rng) for _ in range(args.episodes)]

    everything: list[Outcome] = []
    print(HEAD)
    for number, (name, play) in enumerate(plays()):
        outcomes = played(play, number)
        everything += outcomes
        print(row(name, outcomes), flush=True)
    print(row("all", everything))
    quiet = played(partial(_play, fault=_nothing), 2000)
    print(f"\n{availability(quiet, everything)}")
    print("\nNot among them: what only authentication could tell from the truth")
    for number, (name, fault) in enumerate(MASQUERADE.items(), 1000):
        print(row(name, played(partial(_play, fault=fault), number)), flush=True)
    print(f"\nseed {args.seed}, {time.monotonic() - begun:.0f} s")
    print("without a proof of freshness" if args.without_proof else "with a proof of freshness")
    return 1 if any(outcome.unsafe for outcome in everything) else 0


if __name__ == "__main__":
    sys.exit(main())
