"""The progress bar and the report of `fit` and `update`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tqdm import tqdm

from fmu_compensator.fit.fitting import USUAL_MODEL
from measurement.errors import counted
from scenarios.fit_details import details_text


@contextmanager
def bar() -> Iterator[Callable[[str, float], None]]:
    """Show a bar with the time left; give the function that updates it."""
    form = "{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining}"
    with tqdm(total=1.0, bar_format=form, disable=None, leave=False) as bar:

        def tell(label: str, done: float) -> None:
            bar.set_description(label, refresh=False)
            bar.update(done - bar.n)

        yield tell


def report(table: dict[str, Any], path: Path) -> list[str]:
    """Return the report of a fit as lines.

    Parameters
    ----------
    table : dict
        The compensator file's content.
    path : Path
        The file written.
    """
    provenance, figures = table["provenance"], table["provenance"]["figures"]
    lines = list(provenance["notes"])
    choice = figures["choice"]
    for number, group in enumerate(choice.get("groups", ()), 1):
        scores = [f"{name} {choice['scores'][name]:.2f}" for name in group]
        lines.append(f"group {number}, score to the drift: {', '.join(scores)}")
    if choice.get("hardly_moving"):
        lines.append(f"hardly moving: {', '.join(choice['hardly_moving'])}")
    speed = ", and the spindle speed" if "speed_rpm" in table["gaussian"] else ""
    lines.append(f"temperatures used: {', '.join(table['chosen'])}{speed}")
    model = table["error_model"]
    lines += details_text(model["kind"], model["targets"], figures["fit"])
    if model["kind"] != USUAL_MODEL and "mean_share" in table["gaussian"]:
        shares = zip(model["targets"], table["gaussian"]["mean_share"], strict=True)
        counted = ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares)
        lines.append(f"share of {model['kind']} used with the Gaussian: {counted}")
    promised = promise(figures, len(provenance["runs"]))
    return [promised[0], *lines, *promised[1:], f"wrote {path}"]


def promise(figures: dict[str, Any], runs: int) -> list[str]:
    """Return the promised error as lines: first the worse of like and unlike left-out runs.

    Parameters
    ----------
    figures : dict
        From the file's provenance.
    runs : int
        Number of runs given.
    """
    unseen = figures["unseen"] or {}
    kinds = [kind for kind in ("like", "unlike") if kind in unseen]
    first = promise_line(unseen) or (
        f"no promise for other runs: {counted(runs, 'run')} given, and leaving one out takes at "
        "least three"
    )
    lines = [
        first,
        "",
        f"{'RMSE [um]':<18}"
        + "".join(f"{name:>12}" for name in ("none", "training", "like runs", "unlike runs")),
    ]
    for axis, row in figures["training"].items():
        cells = [
            f"{unseen[kind][axis]['model']:>12.2f}" if kind in unseen else f"{'-':>12}"
            for kind in ("like", "unlike")
        ]
        lines.append(f"{axis:<18}{row['no_model']:>12.2f}{row['model']:>12.2f}{''.join(cells)}")
    if not kinds:
        return lines
    held = ", ".join(
        f"{kind} {100 * min(row['inside'] for row in unseen[kind].values()):.0f} %"
        for kind in kinds
    )
    lines += [
        "like runs: each predicted by a compensator fitted to the others; unlike: a whole "
        "condition left out",
        "promise: the worse of both; an interval that expects more counts as three further runs",
        *(
            f"{axis}: no gain is promised; replay other runs before you send its offset"
            for axis, row in unseen["promised"].items()
            if row["model"] >= row["no_model"]
        ),
        f"share of samples in the 90 % interval, worst axis: {held}",
    ]
    folds = [fold for fold in unseen.get("unlike_folds", ()) if fold["ratio_to_none"] is not None]
    hardest = max(folds, key=lambda fold: fold["ratio_to_none"], default=None)
    if hardest is not None:
        share = 100 * hardest["ratio_to_none"]
        lines.append(f"worst: {hardest['left_out']} left out, {share:.0f} % of the drift remains")
    return lines


def promise_line(unseen: Mapping[str, Any] | None) -> str:
    """Return the error promised for other runs, in a line; empty if there is none.

    Parameters
    ----------
    unseen : mapping or None
        From the file's figures.
    """
    if not unseen:
        return ""
    behind = [
        counted(round(unseen[name]), unit)
        for name, unit in (("like_behind", "run"), ("unlike_behind", "condition"))
        if name in unseen
    ]
    errors = errors_text(unseen["promised"])
    return f"promise, from {' and '.join(behind)} left out: {errors} um RMSE"


def errors_text(by_axis: Mapping[str, Mapping[str, float]]) -> str:
    """Return errors without and with a compensator in words, axis by axis.

    Parameters
    ----------
    by_axis : mapping of str to mapping of str to float
        By axis: ``no_model`` and ``model`` [um].
    """
    return ", ".join(
        f"{axis} {row['no_model']:.1f} -> {row['model']:.1f}" for axis, row in by_axis.items()
    )
