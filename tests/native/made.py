"""Compensator files with random numbers, one per kind of error model, and samples for them."""

import json
from collections.abc import Callable
from itertools import pairwise
from operator import mul
from random import Random
from typing import Any

from fmu_compensator.runtime.gaussian import SPEEDS
from fmu_compensator.runtime.modelfile import Model, parse_model
from tests.fmus.models import five_point_table

FIVE = ("elongation", "yaw", "pitch", "near_x", "near_y")
INF, NAN = float("inf"), float("nan")
Table = dict[str, Any]


def row(random: Random, count: int, low: float = -1.0, high: float = 1.0) -> list[float]:
    return [random.uniform(low, high) for _ in range(count)]


def matrix(random: Random, rows: int, columns: int, size: float = 1.0) -> list[list[float]]:
    return [row(random, columns, -size, size) for _ in range(rows)]


def root(random: Random, size: int) -> list[list[float]]:
    """Return a lower triangular root of a covariance."""
    return [
        [*row(random, place, -4.0, 4.0), random.uniform(0.5, 9.0), *[0.0] * (size - place - 1)]
        for place in range(size)
    ]


def mlr(random: Random, inputs: int, targets: int) -> Table:
    return {"intercept": row(random, targets), "coefficients": matrix(random, targets, inputs, 3.0)}


def bp(random: Random, inputs: int, targets: int) -> Table:
    widths = [inputs, *(random.randint(1, 6) for _ in range(random.randint(0, 2))), targets]
    return {
        "layers": [
            {"weights": matrix(random, after, before, 2.0), "biases": row(random, after)}
            for before, after in pairwise(widths)
        ],
        "input_middle": row(random, inputs, -5.0, 5.0),
        "input_half": row(random, inputs, 1.0, 20.0),
        "output_middle": row(random, targets, -5.0, 5.0),
        "output_half": row(random, targets, 1.0, 20.0),
    }


def arx(random: Random, inputs: int, targets: int) -> Table:
    return {
        "step_s": random.choice([1.0, 7.5, 60.0]),
        "pole": row(random, targets, 0.0, 0.999),
        "now": matrix(random, targets, inputs),
        "before": matrix(random, targets, inputs),
        "constant": row(random, targets),
    }


def arma(random: Random, inputs: int, targets: int) -> Table:
    def series() -> Table:
        return {
            "differences": random.randint(0, 2),
            "mean": random.uniform(-0.01, 0.01),
            "scale": random.uniform(0.01, 2.0),
            # Some run away, up to the limit.
            "ar": row(random, random.randint(0, 3), -1.2, 1.2),
            "ma": row(random, random.randint(0, 3)),
        }

    return {"step_s": random.choice([1.0, 7.5, 60.0]), "series": [series() for _ in range(targets)]}


def ne(random: Random, inputs: int, targets: int) -> Table:
    speeds = sorted(random.sample(range(500, 20000, 10), random.randint(1, 5)))
    return {
        "speeds_rpm": [float(speed) for speed in speeds],
        "steady": matrix(random, targets, len(speeds), 50.0),
        "tau_s": row(random, targets, 1.0, 5000.0),
        "tau_stopped_s": row(random, targets, 1.0, 5000.0),
    }


def fem(random: Random, inputs: int, targets: int) -> Table:
    states, sources = random.randint(1, 4), random.randint(1, 3)
    outside = random.sample(range(inputs), random.randint(0, min(2, inputs)))
    speeds = sorted(random.sample(range(0, 20000, 10), random.randint(1, 4)))
    return {
        "states": states,
        "outside_inputs": outside,
        "regimes": [
            {
                "speed": float(speed),
                "rates": row(random, states, 1e-5, 1e-1),
                "vectors": matrix(random, states, states),
                "outside": matrix(random, len(outside), states, 1e-2),
            }
            for speed in speeds
        ],
        "sources": [
            {
                "viscous": random.uniform(0.0, 1e-5),
                "threshold": random.choice([0.0, 3000.0]),
                "slow": random.uniform(0.0, 1e-2),
                "load": random.uniform(0.0, 1e-2),
                "entry": row(random, states, -1e-3, 1e-3),
            }
            for _ in range(sources)
        ],
        "intercept": row(random, targets),
        "outputs": matrix(random, targets, states * (sources + len(outside))),
    }


def thermal_states(random: Random, inputs: int, targets: int) -> Table:
    lags = [random.choice([60.0, 600.0, 7200.0]) for _ in range(random.randint(0, 3))]
    return {
        "lags_s": lags,
        "start_low": row(random, inputs, -3.0, -1.0),
        "start_usual": row(random, inputs, -0.5, 0.5),
        "start_high": row(random, inputs, 0.6, 3.0),
        "direct": matrix(random, targets, inputs),
        "rise_lags": [matrix(random, targets, inputs) for _ in lags],
        "level_lags": [matrix(random, targets, inputs) for _ in lags],
        "speed_lags": [matrix(random, targets, 2, 0.1) for _ in lags],
    }


def gp(random: Random, inputs: int, targets: int) -> Table:
    lags = [random.choice([60.0, 600.0, 7200.0]) for _ in range(random.randint(0, 3))]
    width, centres = inputs * (1 + len(lags)), random.randint(1, 6)
    return {
        "lags_s": lags,
        "length": random.choice([0.1, 5.0, 50.0]),
        "constant": row(random, targets),
        "linear": matrix(random, targets, width),
        "centres": matrix(random, centres, width, 20.0),
        "weights": matrix(random, targets, centres, 30.0),
    }


def no_mean(random: Random, inputs: int, targets: int) -> Table:
    return {}


def vac(random: Random, inputs: int, targets: int) -> Table:
    kinds = random.sample(sorted(set(MADE) - {"vac"}), random.randint(1, 4))
    models = [{"kind": kind, **MADE[kind](random, inputs, targets)} for kind in kinds]
    weights = {
        name: matrix(random, targets, len(models)) for name in ("stopped", "changing", "steady")
    }
    # A large error in training makes a model whose recent one is small gain as much as may be.
    largest = random.choice([100.0, 1e8])
    prior = [row(random, len(models), 1e-3, largest) for _ in range(targets)]
    return {
        "models": models,
        "weights": weights,
        "prior": random.choice([[], prior]),
        "settle_s": 120.0,
        "blend_s": 60.0,
        "memory_s": 300.0,
    }


MADE: dict[str, Callable[[Random, int, int], Table]] = {
    "arma": arma,
    "arx": arx,
    "bayes": thermal_states,
    "bp": bp,
    "fem": fem,
    "ga_bp": bp,
    "gaussian": no_mean,
    "gp": gp,
    "lasso": thermal_states,
    "mlr": mlr,
    "ne": ne,
    "ridge": thermal_states,
    "thermal_states": thermal_states,
    "vac": vac,
}


def _geometry(random: Random, direct: bool) -> tuple[Table, tuple[str, ...]]:
    if not direct:
        form = random.choice(["rigid", "pure_rotation"])
        place = {"near_to_gauge_mm": 30.5, "spacing_mm": 100.0}
        return {"kind": "five_point", "form": form, **place}, FIVE
    axes = random.sample("XYZ", random.randint(1, 3))
    columns = {f"disp_{axis}": {"axis": axis, "sign": random.choice([1, -1])} for axis in axes}
    return {"kind": "direct", "axes": columns}, tuple(columns)


SEEDS = range(6)
"""Of the files of each kind; every second one has a spare."""
SIX = range(6, 24)
"""Of these a file has as many sensors, all in use, so that it can go on without several."""


def made_model(kind: str, seed: int) -> Model:
    """Return a compensator of one kind; a seed decides on everything else."""
    # Kinds that run the same map are made alike.
    random = Random(f"{MADE[kind].__name__} {seed}")
    sensors = 6 if seed in SIX else random.randint(1, 5)
    chosen = random.sample(range(sensors), sensors if seed in SIX else random.randint(1, sensors))
    geometry, targets = _geometry(random, direct=seed % 3 == 0)
    table = five_point_table() | {
        "name": f"made_{kind}_{seed}",
        "title": "Random numbers",
        "sensors": [_sensor(random, number) for number in range(sensors)],
        "chosen": [f"T{place + 1}" for place in chosen],
        "input_form": ("rise", "absolute", "level")[seed % 3],
        "error_model": {
            "kind": kind,
            "targets": list(targets),
            **MADE[kind](random, len(chosen), len(targets)),
        },
        "geometry": geometry,
        "limits": {
            "offset_um": random.choice([5.0, 150.0, 1e5]),
            "slew_um_per_s": random.choice([0.05, 1.0, 1e4]),
            "hold_s": random.choice([0.0, 40.0]),
            "recover_s": random.choice([0.0, 15.0]),
            "tool_length_mm": random.choice([[0.0, 260.0], [100.0, 100.0]]),
            **random.choice([{}, {"share": random.uniform(0.5, 1.0)}]),
        },
    }
    fixed = seed % 4 == 0 if seed in SIX else random.random() < 0.3
    inputs, outputs = len(chosen), len(targets)
    table["gaussian"] = gaussian(Random(f"gaussian {seed}"), inputs, outputs, fixed)
    spare = _spare(Random(f"spare {seed}"), inputs, outputs, fixed)
    table["spare"] = spare if seed % 2 == 0 else None
    return parse_model(json.dumps(table), "made")


def gaussian(random: Random, inputs: int, targets: int, fixed: bool) -> Table:
    lags = random.sample([30.0, 600.0, 7200.0], random.randint(0, 3))
    width = inputs * (1 + len(lags))
    scale = [random.choice([0.01, 0.1, 3.0]) for _ in range(1 + len(lags))]
    # Of each direction that training saw some variance is left, at times less than none.
    count = random.choice([0, 1, 4, 9, 17])
    size = (random.choice([0.9, 0.9, 3.0]) * max(scale) / (width * max(count, 1))) ** 0.5
    table = {
        "reference": "fixed" if fixed else "start",
        **({"usual": row(random, inputs, 18.0, 24.0)} if fixed else {}),
        "constant": row(random, targets),
        "settled_h": random.choice([0.0, 8.0]),
        "lags_s": lags,
        "weights": matrix(random, targets, width, 2.0),
        "scale": scale,
        "seen": matrix(random, count, width, size),
        "walk_per_h": random.choice([0.0, 0.3, 4.0]),
        "noise": root(random, targets),
        "rows": 100.0,
        "deviations": 2.35,
        "coverage": 0.9,
        **({"mean_share": row(random, targets, 0.0, 1.0)} if count != 1 else {}),
    }
    if random.random() < 0.5:
        table["speed_rpm"] = random.choice([2000.0, 8000.0])
        for name, most in (("weights", 2.0), ("seen", size)):
            for numbers in table[name]:
                for at in range(width, 0, -inputs):  # after the sensors, without and with each lag
                    numbers[at:at] = row(random, SPEEDS, -most, most)
    return table


def _spare(random: Random, inputs: int, targets: int, fixed: bool) -> Table:
    # A sum of squares and something on the diagonal is a precision.
    parts = matrix(random, inputs, inputs, 2.0)
    precision = [[sum(map(mul, a, b)) for b in parts] for a in parts]
    for place in range(inputs):
        precision[place][place] += random.choice([0.1, 10.0])
    return {
        "precision": precision,
        "growth": row(random, inputs, 0.0, 9.0),
        "memory_s": random.choice([1.0, 600.0, 1e5]),
        "usual_start": None if fixed else row(random, inputs, -9.0, 9.0),
        "sensitivity": matrix(random, targets, inputs, random.choice([0.1, 0.3, 30.0])),
    }


def _sensor(random: Random, number: int) -> Table:
    by_hand = five_point_table(1)["sensors"][0] | {"low": -20.5, "high": 120.25}
    by_hand |= {"name": f"T{number + 1}", "rate_per_s": random.choice([0.05, 2.0])}
    return by_hand | {"stale_after_s": random.choice([None, 30.0])}


class Samples:
    """A machine that warms up, whose sensors, clock and tool table go wrong now and then."""

    def __init__(self, model: Model, seed: int) -> None:
        self.random = Random(f"samples {seed}")
        self.model = model
        self.joint = row(self.random, len(model.targets), -9.0, 9.0)
        self.time = self.random.choice([0.0, 1e5])
        self.base = [self.random.uniform(18.0, 24.0) for _ in model.sensors]
        self.shift = [0.0 for _ in model.sensors]
        self.stuck = [0 for _ in model.sensors]
        self.speed, self.tool = 0.0, sum(model.limits.tool_length_mm) / 2.0
        self.shown = list(self.base)
        self.unheard = 3 * (seed % 2)  # samples at the start without a speed
        self.silent: dict[int, int] = {}  # samples for which a sensor says nothing

    def silence(self, samples: int, sensors: int = 1) -> None:
        """Let some of the sensors in use say nothing for a while, from now on."""
        for place in self.random.sample(self.model.chosen, min(sensors, len(self.model.chosen))):
            self.silent[place] = samples

    def next(self) -> tuple[float, float, list[float], float, float, list[float] | None]:
        """Return time, step, temperatures, speed, tool length and measured targets."""
        random = self.random
        step = random.choice([1.0, 1.0, 1.0, 10.0, 0.3, 600.0])
        self.time += step
        if random.random() < 0.02:
            self.speed = random.choice([0.0, 0.5, 1000.0, 8000.0, 16000.0, 3e4])
        if random.random() < 0.01:  # a joint settles
            self.joint = row(random, len(self.model.targets), -300.0, 300.0)
        measured = None
        if random.random() < 0.2:
            measured = [value + random.uniform(-2.0, 2.0) for value in self.joint]
            if random.random() < 0.2:
                measured[0] = random.choice([NAN, INF, 1e300, 4000.0])
        return (
            self._now(),
            step,
            [self._reading(number) for number in range(len(self.base))],
            self._turning(),
            random.choice([NAN, -INF, -3.0, 1e300]) if random.random() < 0.02 else self.tool,
            measured,
        )

    def _turning(self) -> float:
        random, speed = self.random, self.speed
        if random.random() < 0.05:
            speed = random.choice([NAN, INF, -speed, 1e300])
        self.unheard -= 1
        return speed if self.unheard < 0 else NAN

    def _now(self) -> float:
        odd = self.random.random()
        if odd < 0.02:
            return self.time + self.random.choice([-100.0, 1e12, -3.0, 1e9, 1e4])
        return self.time

    def _reading(self, number: int) -> float:
        random = self.random
        self.base[number] += random.uniform(-0.02, 0.05)
        if random.random() < 0.01:
            self.shift[number] = random.choice([0.0, 0.0, 8.0, -8.0, 200.0, -1e300])
        if random.random() < 0.01:
            self.stuck[number] = random.randint(1, 60)
        if self.stuck[number] > 0:
            self.stuck[number] -= 1
        else:
            self.shown[number] = self.base[number] + self.shift[number]
        if self.silent.get(number, 0) > 0:
            self.silent[number] -= 1
            return NAN
        if random.random() < 0.01:
            return random.choice([NAN, INF, -INF])
        return self.shown[number]
