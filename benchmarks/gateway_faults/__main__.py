"""Play seeded episodes of faults against a gateway, and count what was unsafe and called valid.

``python -m benchmarks.gateway_faults [--episodes N] [--write]``
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

import benchmarks.gateway_faults.old  # noqa: F401  (registers its classes)
from benchmarks.gateway_faults.classes import FAULTS, MASQUERADE, cycles
from benchmarks.gateway_faults.harness import Episode, Outcome
from benchmarks.gateway_faults.states import RESTARTS
from benchmarks.results_page import as_table, parser_of, tell
from gateway.database import Database
from gateway.mapping import read_database
from gateway.node import GatewaySettings

ON_THE_MACHINES_CLOCK = ("gateway stopped, then goes on", "machine's clock stands, step 0")
HEAD = ("", "Episodes", "Answers", "Unsafe")
MOST_UNPROVEN = 20
"""Episodes of each class with a machine that proves nothing: what is unsafe then shows in fewer."""
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
    return (
        f"Without a fault {valid:,} of {answers:,} answers are valid. Where a fault was noticed "
        f"and the offsets are valid at the end ({len(back):,} episodes), 99 % are valid again "
        f"within {most:.2f} s of the fault's end, and all within {back[-1]:.2f} s."
    )


def row(name: str, outcomes: list[Outcome]) -> list[str]:
    """Return a row of the table."""
    answers, unsafe = (sum(getattr(o, of) for o in outcomes) for of in ("answers", "unsafe"))
    return [name, *(f"{count:,}" for count in (len(outcomes), answers, unsafe))]


def main() -> int:
    """Play, print, and return 1 if anything unsafe was called valid that a proof can tell."""
    parser = parser_of(__doc__, "benchmarks.gateway_faults")
    parser.add_argument("--episodes", type=int, default=20, help="of each class (20)")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()

    def played(play: Play, number: int, database: Database, episodes: int) -> list[Outcome]:
        rng = np.random.default_rng([args.seed, number])
        return [play(database, rng) for _ in range(episodes)]

    def campaign(database: Database, episodes: int) -> dict[str, list[Outcome]]:
        found = {}
        for number, (name, play) in enumerate(plays()):
            found[name] = played(play, number, database, episodes)
            print("  ".join(row(name, found[name])), flush=True)
        return found

    database = read_database()
    proven = campaign(database, args.episodes)
    everything = [one for outcomes in proven.values() for one in outcomes]
    unproven = campaign(database.unproven(), min(args.episodes, MOST_UNPROVEN))
    unsafe = {n: found for n, found in unproven.items() if any(one.unsafe for one in found)}
    others = [one for name, found in unproven.items() if name not in unsafe for one in found]
    rows = [
        row("with a proof of freshness", everything),
        *(row(f"`--freshness any`: {name}", found) for name, found in unsafe.items()),
        row("`--freshness any`: all other classes", others),
    ]
    for number, (name, fault) in enumerate(MASQUERADE.items(), 1000):
        found = played(partial(_play, fault=fault), number, database, args.episodes)
        rows.append(row(f"no fault but a forgery: {name}", found))
    quiet = played(partial(_play, fault=_nothing), 2000, database, args.episodes)
    text = f"{as_table(HEAD, rows)}\n\n{availability(quiet, everything)}"
    tell("gateway_faults", text, write=args.write)
    return 1 if any(outcome.unsafe for outcome in everything) else 0


if __name__ == "__main__":
    sys.exit(main())
