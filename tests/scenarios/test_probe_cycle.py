"""A probe cycle in the loop: when it comes, and what it brings."""

import numpy as np

from scenarios.cosimulation import simulate
from scenarios.probe_cycle import ProbeSource
from scenarios.scenario import Probe, read_scenario


def test_probes_come_at_the_communication_points_that_the_interval_names():
    # 36 x 0.3 is less than 10.8.
    source = ProbeSource(Probe(every_s=10.8), ["dX"], ["dX"], None, "s.toml", from_start=True)
    taken = [source.measured(k * 0.3, np.zeros(1), []) is not None for k in range(400)]
    assert np.flatnonzero(taken).tolist() == list(range(36, 400, 36))


def test_a_probe_cycle_in_the_loop(shipped_in_c):
    frames = {
        case.name: simulate(
            case,
            shipped_in_c / "plant_native.fmu",
            shipped_in_c / "compensator_native.fmu",
            quiet=True,
        ).frame
        for case in read_scenario("probing", [("step_s", 10.0), ("duration_s", 21600.0)]).cases
    }
    assert "measured_1" not in frames["no_probe"]
    hourly = frames["hourly"]
    probed = hourly["time_s"][hourly["measured_1"] > 0].to_numpy()
    assert probed.tolist() == (3600.0 * np.arange(1, 7)).tolist()
    after = int(np.flatnonzero(hourly["measured_1"])[0])
    before, behind = (hourly["dX_uncertainty_um"].iloc[after + k] for k in (0, 3))
    assert behind < before
    error = {name: frame["error_Z_um"].abs().mean() for name, frame in frames.items()}
    assert error["hourly"] < 0.7 * error["no_probe"]
    asked = frames["on_demand"]
    widths = asked[["dX_uncertainty_um", "dY_uncertainty_um", "dZ_uncertainty_um"]].max(axis=1)
    assert asked["measured_1"].any()
    assert (widths[asked["measured_1"] > 0] > 1.5).all()
