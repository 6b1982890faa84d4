"""Back-propagation network whose size and start a genetic algorithm chose."""

from __future__ import annotations

from fmu_compensator.runtime.error_models.bp import BackPropagation


class GeneticBackPropagation(BackPropagation):
    """Runs as any network does: the genetic algorithm has done its work in training."""
