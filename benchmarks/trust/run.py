"""Fit each error model on some runs, install it, and drive it through runs that it never saw.

    python -m benchmarks.trust.run DATA [--models NAME,NAME] [--data lathe] [--json FILE] [--write]

DATA is the folder that holds ``lathe/`` and ``electric_spindle/``; what is missing is left out.
The answers are kept in FILE as they come, and a run that was stopped goes on from there;
``--write`` writes the tables into docs/results.md.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tqdm import tqdm

from benchmarks.results_page import parser_of, tell
from benchmarks.trust.judge import CHOICE, PROTOTYPE, judge
from benchmarks.trust.questions import questions
from benchmarks.trust.tables import tables
from measurement.errors import BadInput
from measurement.files import write_atomically

MODELS = f"{CHOICE},{PROTOTYPE},mlr,bayes,ridge,lasso,arx,ne,gp,thermal_states,bp"


def main() -> int:
    """Ask what was not asked yet and print the tables."""
    parser = parser_of(__doc__)
    parser.add_argument("folder", type=Path, metavar="DATA")
    parser.add_argument("--models", default=MODELS)
    parser.add_argument("--data", help="only this data set")
    parser.add_argument("--json", type=Path, default=Path("results/trust.json"))
    args = parser.parse_args()
    found: list[dict[str, Any]] = json.loads(args.json.read_text()) if args.json.exists() else []
    asked = {(one["data"], one["question"], one["model"]) for one in found}
    todo = [
        (question, model)
        for question in questions(args.folder)
        if args.data in (None, question.data)
        for model in args.models.split(",")
        if (question.data, question.name, model) not in asked
    ]
    for question, model in tqdm(todo, disable=None):
        try:
            found.append(judge(question, model))
        except BadInput as refusal:
            asked_for = {"data": question.data, "question": question.name, "model": model}
            found.append(asked_for | {"refused": str(refusal)})
        args.json.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(args.json, json.dumps(found, indent=1) + "\n")
    order = {model: place for place, model in enumerate(MODELS.split(","))}
    text = tables(sorted(found, key=lambda one: order.get(one["model"], len(order))))
    tell("trust", text, write=args.write)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
