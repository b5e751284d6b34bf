"""`experiment` and `log`: runs in virtual time, and their logs."""

import inspect
import os
import pickle
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from fractional_haptics import analysis, experiment, log, plot, tissue

SHORT = {"duration_s": 3.0, "ramp_time_s": 0.5}
WALL = {
    "mass_kg": 0.065,
    "damping_n_s_per_m": 3.5,
    "sample_time_s": 2e-3,
    "order": 0.5,
    "stiffness_n_per_m": 3000.0,
    "dissipation_n_s_mu_per_m": 30.0,
}


def test_a_relaxation_is_its_closed_form() -> None:
    run = experiment.relax(**SHORT)
    assert list(run.columns)[:3] == ["time_s", "ideal_position_m", "position_m"]
    late = run["time_s"] > 1.0
    np.testing.assert_allclose(run["simulated_force_n"][late], run["closed_form_force_n"][late], rtol=5e-3)
    model = tissue.find("prostate-cancerous").model
    t = np.array([0.0, 0.5, 3.0])
    want = 4e-4 * model.stress(t, np.array([0.0, 0.05, 0.05]))[-1]
    assert abs(run["closed_form_force_n"][-1] / want - 1) < 1e-9
    assert run.folder is None
    assert "log" not in run.report
    assert run.to_frame().attrs["report"]["samples"] == len(run["time_s"]) == 3001
    assert plot.relaxation(run).get_xlabel() == "time / s"
    with pytest.raises(KeyError, match="is not one of the columns"):
        run["force"]


def test_a_record_is_laid_over_a_run(tmp_path: Path) -> None:
    first = experiment.relax(**SHORT)
    assert not first.against
    rows = np.column_stack([first["time_s"], 0.8 * first["simulated_force_n"]])
    record = tmp_path / "record.csv"
    np.savetxt(record, rows, fmt="%.17g", delimiter=",", header="time_s,force_n", comments="")
    run = experiment.relax(**SHORT, against=record)
    # The run is a quarter above the record.
    assert abs(run.report["against_error"] - 0.25) < 1e-12
    np.testing.assert_allclose(run.against["relative_error"][1:], 0.25, rtol=1e-12)
    assert list(run.against) == ["time_s", "record_force_n", "simulated_force_n", "difference_force_n", "relative_error"]
    assert run.report["against"]["record"] == str(record)
    assert "csv" not in run.report["against"]
    assert len(plot.relaxation(run).get_lines()) == 3
    with pytest.raises(ValueError, match="from 0 s to 0.4 s after the start"):
        record.write_text("time_s,force_n\n0,0\n0.2,1\n0.4,2\n")
        experiment.relax(**SHORT, against=record)


def test_same_seed_same_run() -> None:
    noisy = {**SHORT, "sensor_noise_m": 1e-6}
    first, again, other = (experiment.relax(**noisy, seed=seed)["simulated_force_n"] for seed in (3, 3, 4))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_creep_reaches_its_strain() -> None:
    run = experiment.creep(duration_s=3.0)
    assert run["closed_form_strain"][-1] > 0
    assert abs(run["simulated_strain"][-1] / run["closed_form_strain"][-1] - 1) < 0.05


def test_a_run_that_a_fault_ends_raises_with_its_report(tmp_path: Path) -> None:
    fast = {**WALL, "speed_limit_m_per_s": 1e-3, "duration_s": 1.0}
    with pytest.raises(experiment.RunFault, match="faster than its limit: the run ended at") as caught:
        experiment.wall(**fast, out=tmp_path)
    run = caught.value.run
    assert run.report["ended_early"] in str(caught.value)
    assert log.read_log(run.report["log"]).attrs["complete"] is True
    assert pickle.loads(pickle.dumps(caught.value)).run.report == run.report
    kept = experiment.wall(**fast, raise_on_fault=False)
    assert kept.report["ended_early"] == run.report["ended_early"]
    assert experiment.wall(**{**fast, "speed_limit_m_per_s": 10.0}).report["ended_early"] is None


def test_a_coupler_runs() -> None:
    run = experiment.coupler(
        mass_kg=0.065,
        damping_n_s_per_m=3.5,
        sample_time_s=1e-3,
        order=1.0,
        coupler_damping_n_s_per_m=0.5,
        coupler_spring_n_s_1_minus_mu_per_m=500.0,
        duration_s=2.0,
    )
    assert "object_position_m" in run.columns


def test_a_file_and_its_log_run_again_and_a_table_is_none(tmp_path) -> None:
    file = tmp_path / "wall.toml"
    keys = {**WALL, "duration_s": 1.0, "window_s": 0.2}
    file.write_text("[wall]\n" + "".join(f"{key} = {value}\n" for key, value in keys.items()), encoding="utf-8")
    run = experiment.run(file, out=tmp_path / "run", stiffness="1 kN/m")
    same = experiment.wall(**{**keys, "stiffness_n_per_m": 1000.0})
    again = experiment.run(tmp_path / "run" / "wall.mcap")
    for other in (same, again):
        assert other.kind == run.kind == "wall"
        assert np.array_equal(other["reaction_force_n"], run["reaction_force_n"])
    with pytest.raises(FileNotFoundError):
        experiment.run(tmp_path / "none.toml")
    table = tmp_path / "record.csv"
    table.write_text("time_s,strain\n0,0\n", encoding="utf-8")
    with pytest.raises(ValueError, match="is a table, no experiment"):
        experiment.run(table)


def test_a_press_and_a_teleoperation_run() -> None:
    pressed = experiment.press(tissue="liver", depth="1 mm", hold_time="0.5s")
    assert abs(pressed["position_m"][-1] / 1e-3 - 1) < 0.02 and pressed["force_n"][-1] > 0
    far = experiment.teleoperation(duration_s=6.0)
    assert far.kind == "teleoperation" and far.report["samples"] == len(far["slave_force_n"])


def test_zwidth_finds_what_the_analysis_says() -> None:
    done: list[int] = []
    report = experiment.zwidth(orders=[1.0], points=3, progress=done.append)
    points = report["orders"][0]["boundary"]
    assert len(points) == 3
    # The last is at the largest dissipation, where next to no stiffness is left.
    for point in points[:-1]:
        assert abs(point["stiffness_max"] / point["analysis_stiffness_n_per_m"] - 1) < 0.05
    assert done == sorted(done)
    specimen = experiment.zwidth(tissue=tissue.find("liver"), area_m2=1e-4)
    assert specimen["tissue"] == "liver"
    assert abs(specimen["largest_scale"] / specimen["analysis_scale"] - 1) < 0.05


def test_a_design_comes_to_rest_when_it_is_tried() -> None:
    report = experiment.design(orders=[0.5, 1.0], gain_margin=2.0)
    assert report["best"]["stiffness_n_per_m"] == max(c["stiffness_n_per_m"] for c in report["candidates"])
    assert report["simulated"]["verdict"] == "stable"
    damped = experiment.design(orders=[1.0], wish="most-damping", frequency_hz=5.0, require="passive")
    assert damped["best"]["passive"] is True
    coupled = experiment.design(orders=[1.0], wish="coupler")
    assert coupled["best"]["coupler_spring_n_s_1_minus_mu_per_m"] > 0
    specimen = experiment.design(orders=[0.5], wish="tissue", tissue=tissue.find("prostate-healthy"))
    assert specimen["tissue"]["name"] == "prostate-healthy"


def test_an_analysis_is_that_of_the_library() -> None:
    wall = {"order": 0.5, "stiffness_n_per_m": 300.0, "dissipation_n_s_mu_per_m": 10.0, "sample_time_s": 2e-3}
    device = {"mass": "65 g", "damping_n_s_per_m": 3.5, "delay_s": 2.6e-3, "current_lag_s": 1e-3}
    report = experiment.analyze_stability(**wall, **device)
    loop = analysis.Loop(analysis.Device(0.065, 3.5, delay_s=2.6e-3, current_lag_s=1e-3), 300.0, 10.0, 0.5, 2e-3)
    assert report["stable"] is loop.verdict().stable is True
    assert report["gain_margin"] == pytest.approx(loop.margins().gain_up.value, rel=1e-9)
    far = experiment.analyze_teleoperation(tissue=tissue.find("prostate-healthy"), points=3)
    assert far["tissue"] == "prostate-healthy" and len(far["points"]) == 3
    with pytest.raises(ValueError, match="^`beta` is missing"):
        experiment.analyze_passivity(order=1.0, alpha=0.1)
    body = {"body_order": 0.7, "body_inertance_n_s_mu_per_m": 4.0, "body_damping_n_s_per_m": 0.5, "sample_time": "2 ms"}
    robot = experiment.analyze_admittance(**body, bandwidth="10 Hz", dead_time="4 ms", force_cutoff="30 Hz")
    assert robot["stable"] is True
    assert robot["largest_hand_stiffness_n_per_m"] == pytest.approx(599.057, rel=1e-5)


def test_an_answer_has_the_warnings_that_the_command_prints() -> None:
    half = experiment.analyze_stability_region(order=1.0, alpha=0.1, delta=0.1)
    assert half["warnings"] == ["no wall is marked: give both `stiffness_n_per_m` and `dissipation_n_s_mu_per_m`, or `alpha` and `beta`"]
    none = experiment.design(orders=[1.0], scheme="muir:3", force_noise_limit_n=1e-9, encoder_resolution_m=1e-3)
    assert none["best"] is None and len(none["warnings"]) == 1


def test_signatures_are_those_of_the_tables() -> None:
    parameters = inspect.signature(experiment.relax).parameters
    assert parameters["strain"].default == 0.05
    assert parameters["tissue"].default == "prostate-cancerous"
    assert "strain : float, default 0.05\n    Strain to hold (above 0 and at most 1)." in experiment.relax.__doc__
    assert inspect.signature(experiment.wall).parameters["mass_kg"].default is inspect.Parameter.empty
    assert inspect.signature(experiment.zwidth).parameters["mass_kg"].default == 0.065
    assert "order" not in inspect.signature(experiment.zwidth).parameters


def test_progress_and_a_bar() -> None:
    class Bar:
        n = 0

        def update(self, count: int) -> None:
            self.n += count

    bar, seen = Bar(), []
    experiment.relax(**SHORT, progress=bar)
    experiment.relax(**SHORT, progress=seen.append)
    assert bar.n == seen[-1] == 3001


def test_ctrl_c_stops_a_run(tmp_path) -> None:
    # Virtual time: an hour of tissue takes long enough to be stopped.
    def interrupt() -> None:
        time.sleep(0.3)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        experiment.relax(duration_s=36_000.0, out=tmp_path / "long")
    assert time.monotonic() - begun < 20
    table = log.read_log(tmp_path / "long" / "relax.mcap")
    assert table.attrs["complete"] is True
    assert table.attrs["metadata"]["end"]["ended"] == "interrupted"
    # Nobody waits for the end of its report, after which a verdict would be added: the log stays as it was closed.
    assert "verdict" not in table.attrs["metadata"]


def test_a_log_has_the_run_and_its_metadata(tmp_path) -> None:
    run = experiment.relax(**SHORT, out=tmp_path)
    assert run.folder == tmp_path
    table = log.read_log(run.report["log"])
    assert table.index.name == "time_s"
    np.testing.assert_allclose(table.index, run["time_s"], atol=1e-12)
    assert np.array_equal(table["position_m"], run["position_m"])
    # In the log a force is positive along the position.
    assert np.array_equal(-table["commanded_force_n"], run["simulated_force_n"])
    assert table["limiters"].dtype == np.uint8
    assert table.attrs["complete"] is True
    assert table.attrs["damage"] == []
    assert table.attrs["metadata"]["experiment"]["program"].startswith("fractional-haptics (Python)")
    assert table.attrs["started"].endswith("Z")
    assert table.attrs["metadata"]["verdict"]
    with pytest.raises(ValueError, match="overwrite"):
        experiment.relax(**SHORT, out=tmp_path)
    experiment.relax(**SHORT, out=tmp_path, overwrite=True)


def test_a_force_sensor_is_a_column_of_the_log(tmp_path) -> None:
    run = experiment.relax(**SHORT, sensed_range_n=20.0, contact="rigid", out=tmp_path)
    sensed = log.read_log(run.report["log"])["sensed_force_n"]
    # The noise is 1 mN, the lag 1 ms.
    near = np.abs(sensed - run["simulated_force_n"])[sensed.notna()]
    assert len(near) > 0 and near.median() < 2e-3
    assert run.report["sensed"]["from_rendered"]["rms_n"] > 5e-4
    without = experiment.relax(**SHORT, out=tmp_path / "without")
    assert log.read_log(without.report["log"])["sensed_force_n"].isna().all()


def test_a_touch_has_a_column_for_each_axis(tmp_path) -> None:
    run = experiment.touch(radius_m=0.02, mass_kg=[0.05, 0.1], duration_s=2.0, out=tmp_path)
    assert run.report["verdict"] == "passive"
    # The hand goes 2 mm into the disc and the disc pushes it out again.
    assert 0.2e-3 < run.report["largest_depth_m"] < 2e-3
    table = log.read_log(run.report["log"])
    assert len(table) == run.report["samples"] == 2001
    for name in ("position", "reference"):
        for axis in "xy":
            assert np.array_equal(table[f"{name}_{axis}_m"], run[f"{name}_{axis}_m"])
    assert "position_m" not in table and "position_z_m" not in table
    depth = 0.02 - np.hypot(table["position_x_m"], table["position_y_m"])
    np.testing.assert_allclose(np.maximum(depth, 0.0), run["depth_m"], atol=1e-15)
    # Along the normal: force and place have one direction.
    across = table["commanded_force_x_n"] * table["position_y_m"] - table["commanded_force_y_n"] * table["position_x_m"]
    assert np.abs(across).max() < 1e-12
    assert table.attrs["metadata"]["experiment"]["axes"] == "2"
    with pytest.raises(ValueError, match="3 numbers, not one for each of 2 axes"):
        experiment.touch(centre_m=[0.0, 0.0, 0.0])
    space = experiment.touch(
        axes=3, shape="plane", normal=(0, 0, -1), way_points=[[0, 0, 0, 1e-3], [1, 0.01, 0, -2e-3]], duration_s=1.0
    )
    assert space["force_z_n"].max() > 0.3
    assert not space["force_x_n"].any()


def test_a_cut_log_is_read_as_far_as_it_goes(tmp_path) -> None:
    run = experiment.relax(**SHORT, out=tmp_path)
    whole = log.read_log(run.report["log"])
    content = (tmp_path / "relax.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(content[: len(content) // 2])
    table = log.read_log(cut)
    assert table.attrs["complete"] is False
    assert len(table.attrs["damage"]) == 1
    assert 100 < len(table) < len(whole)
    assert table.equals(whole.iloc[: len(table)])


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: experiment.relax(strain=5.0), r"^strain = 5 is not above 0 and at most 1"),
        (lambda: experiment.relax(strian=0.5), "strian"),
        (lambda: experiment.relax(strain=[0.5]), "strain is an array, not a number"),
        (lambda: experiment.relax(tissue="jelly"), "jelly"),
        (lambda: log.read_log(__file__), "MCAP"),
    ],
)
def test_what_is_wrong_is_refused_with_a_reason(call, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        call()


def test_a_device_that_is_not_there_is_a_runtime_error() -> None:
    with pytest.raises(RuntimeError, match="no-such-port"):
        experiment.relax(**SHORT, device="serial:/dev/no-such-port")
