"""What the command ``fit`` says."""

from measurement.runs import write_run
from scenarios.cli import main
from tests.fmu_compensator.conftest import make_run


def test_a_rig_that_nobody_described_is_told(tmp_path, capsys):
    runs = [str(write_run(make_run(f"r{n}", n, hours=1.0), tmp_path / f"r{n}.csv")) for n in (0, 1)]
    said = "S1, S2 30 mm outside the gauge line, S3, S4 100 mm further out, S5 towards +Z"
    for machine, told in (([], True), (["--machine", "jig_borer"], False)):
        out = str(tmp_path / f"{told}.json")
        assert main(["fit", *runs, *machine, "--points", "T1,T4", "-o", out]) == 0
        assert (said in capsys.readouterr().out) is told
