"""What the page on the studies' experiment says around its tables."""

PAGE = """# The studies' experiment, rebuilt

Three studies learn a model of a spindle's drift on a step spectrum of speeds, predict another
spectrum, and compensate. `python -m benchmarks.studies --write` does the same on two simulated
machines and writes this page. Figures stand as they came out, the studies' own beside them. The
methods are those of [methods.md](methods.md).

- **Jig borer**: the plant of this project, a network of lumps, with eleven thermometers and five
  displacement sensors.
- **Finite elements**: an axisymmetric spindle of the [same size](finite_elements.md). Its bearing
  friction is 25 % higher, its motor loss 10 % lower, its jackets 15 % weaker and its films'
  diameters 30 % smaller than in the description that the model `fem` starts from. It grows and
  does not tilt. Six thermometers on its resting parts, one in the air, one in the coolant.

Both: eight hours every 30 s, 0.03 K and 0.2 um of noise, 0.01 K and 0.1 um of resolution. Learnt
from `step_speed` alone, judged on `random_speed`, which no model has seen. Temperatures are chosen
on the training run, by what is usual for the model.

## Prediction on the jig borer

Predictive ability eta = 1 - sum|e| / sum|y|, the studies' in brackets.

{lumps}

- **Fit.** Elongation as in the studies. Yaw and pitch fit worse: they are 10 to 20 urad here, from
  two sensors with 0.2 um of noise each. Persistence, the reading of 30 s before, shows how much of
  them is noise.
- **BP against GA-BP, unseen.** The study's order comes out for elongation, by four points where
  it had two and a half. For yaw and pitch GA-BP is no better. What fails is not the search for a
  minimum: one run holds too little about the tilt.
- **A straight line wins.** MLR and ARX predict the unseen spectrum better than any network. The
  simulated spindle is nearly linear in its temperatures, and the networks learn noise with the
  rest of their numbers.
- **Time series.** One step ahead it is as good as persistence, and both beat every other model.
  Free-running it is of no use. The study's figures above 90 % are of the first kind: they say how
  slowly the drift moves.
- **Natural exponential.** It knows the speed and nothing else, and an unseen spectrum is short
  stretches that never settle.
- **FEM.** It predicts the growth. An axisymmetric spindle does not tilt, so its yaw and pitch are
  no more than a guess.
- **VAC.** The hybrid lies between its parts, not above them as in the study: one training run
  leaves none to learn the weights from.
- **Thermal states** are made for many runs. From one, they predict the growth and not the tilt.

## Prediction on the finite-element spindle

{elements}

- BP comes out at the study's figure for unseen elongation, GA-BP a little below its own. The two
  are alike here.
- `fem` starts from another description and has three factors to fit. It has the equations of this
  machine all the same, so its figure is flattering, and so are those of the hybrids that hold it.

## Convergence

{convergence}

The error is the mean square at the outputs, each scaled to -1 to 1. The study's GA-BP is there
after 72 iterations, its BP not within 1000. Here, too, the genetic search hands over a start that
is 14 to 50 times better. But BP is within one percent of its end after two dozen iterations at
most: Levenberg-Marquardt with an exact Jacobian needs no better start.

## Compensation

What is left of the tool tip's drift on the unseen spectrum, X / Y / Z, if the predicted pose is
sent as an offset for the tool's length. "Better" is 1 - mean after / mean before, of sizes. The
study's X and Y are those of its distal sensors.

{compensation}

- Z does not depend on the tool's length, in the studies as here.
- X and Y do. BP and GA-BP halve them, where the study's GA-BP leaves a fifth. One run tells them
  little about the tilt; and the mean drift is a third of the studies', so that the noise of the
  displacement sensors weighs more.
- The study's best, the time series, needs displacement sensors while the machine cuts.

## Four runs instead of one

Learnt from four runs (`training_down`, `training_random`, `training_stops`, `training_warm_hall`),
judged on three others (`step_speed`, `random_speed`, `stop_and_go`) by the compensator itself,
sample by sample: what it leaves of the measured drift, half the width of its 90 % interval, and
how much of the drift lies within [um].

{intervals}

With four runs, thermal states leave half of what the next best leaves, or less. The interval is
that of the worst of the four, and holds more than it promises.
"""
