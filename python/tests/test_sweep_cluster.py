"""Sweeps on a Dask cluster: workers and schedulers die, numbers stay."""

import contextlib
import logging
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

pytest.importorskip("xarray")
distributed = pytest.importorskip("distributed")

from fractional_haptics.sweep import ClusterLost, Grid, SweepError, axis, samples, sweep
from fractional_haptics.sweep.cluster import Cluster

GRID = Grid(x=axis(np.linspace(0, 1, 10), "m"), draw=samples(12))


def drawn(x, rng):
    if x == 1.0:
        raise ValueError("at the end")
    return {"y": np.sin(x) * rng.standard_normal(), "z": rng.standard_normal(3)}


def slow(x, rng):
    time.sleep(0.004)
    return drawn(x, rng)


OUTPUTS = {"y": "m"}


@contextlib.contextmanager
def cluster(folder, workers, as_worker='exec "$@"'):
    """A scheduler and workers as processes of their own, and a client; `as_worker` is the shell around a worker."""
    file = folder / "scheduler.json"
    here = {
        **os.environ,
        "PYTHONPATH": str(Path(__file__).parent),  # where the functions of this file are
        "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1",
    }

    def begin(shell, program, *options):
        command = ["sh", "-c", shell, "sh", sys.executable, "-m", f"distributed.cli.{program}", *options]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        command += ["--scheduler-file", file]
        return subprocess.Popen(command, cwd=folder, env=here, start_new_session=True, **quiet)

    processes = [begin('exec "$@"', "dask_scheduler", "--port", "0", "--dashboard-address", ":0")]
    for _ in range(workers):
        processes.append(begin(as_worker, "dask_worker", "--nthreads", "1", "--no-dashboard", "--no-nanny"))
    try:
        give_up = time.monotonic() + 300
        while not file.exists():
            assert time.monotonic() < give_up
            time.sleep(0.05)
        with distributed.Client(scheduler_file=str(file), timeout=600) as connected:
            yield processes, connected
    finally:
        for process in processes:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    """Two workers; one that ends is begun again. Not by Dask's nanny, which leaves one that ends while it starts."""
    with cluster(tmp_path_factory.mktemp("cluster"), workers=2, as_worker='while :; do "$@"; done') as (_, connected):
        yield connected


def test_a_cluster_gives_the_bits_of_one_thread_with_a_worker_killed_in_the_middle(client, tmp_path):
    whole = sweep(drawn, GRID, workers=1, seed=5)
    killed = []

    def kill(progress):
        if progress.done > 20 and not killed:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    result = sweep(slow, GRID, client, tmp_path / "s", seed=5, block_points=6, progress=kill)
    assert killed
    for name in ("y", "z"):
        assert_array_equal(result[name], whole[name])
    assert_array_equal(result["error"], whole["error"])
    assert int((result["error"] == "ValueError: at the end").sum()) == 12
    assert len((tmp_path / "s" / "_done").read_text().splitlines()) == 20


def test_what_threads_began_a_cluster_ends(client, tmp_path):
    class Stopped(Exception):
        pass

    def stop(progress):
        if progress.done > 30:
            raise Stopped

    with pytest.raises(Stopped):
        sweep(drawn, GRID, store=tmp_path / "s", block_points=6, progress=stop)
    result = sweep(drawn, GRID, client, tmp_path / "s")
    assert_array_equal(result["y"], sweep(drawn, GRID)["y"])


def test_a_block_that_ends_its_workers_is_failed_and_tried_again_later(client, tmp_path):
    deadly = tmp_path / "deadly"
    deadly.touch()
    path = str(deadly)

    def kills(x):
        if x == 3 and os.path.exists(path):
            os._exit(1)
        return x

    options = {"store": tmp_path / "s", "outputs": {"value": "1"}, "block_points": 1}
    first = sweep(kills, {"x": range(6)}, client, **options).load()
    # A block that waited on both workers when they died counts as failed too: it is for Dask to say which.
    failed = [error.item().startswith("KilledWorker: ") for error in first["error"]]
    assert failed[3]
    assert_array_equal(np.isnan(first["value"]), failed)
    assert_array_equal(first["error"] == "", np.logical_not(failed))
    deadly.unlink()
    again = sweep(kills, {"x": range(6)}, client, **options)
    assert_array_equal(again["value"], np.arange(6.0))
    assert (again["error"] == "").all()


def test_a_function_that_cannot_be_sent_is_refused(client):
    lock = threading.Lock()

    def holds(x):
        with lock:
            return x

    with pytest.raises(TypeError, match=r"cannot be sent to a cluster.*lock.*Open devices, files and locks inside it"):
        sweep(holds, {"x": [1.0]}, client)
    table = np.zeros(200_000)
    with pytest.raises(ValueError, match="takes 16.* bytes with all that is bound to it.*read large data inside it"):
        sweep(lambda x: table[int(x)], {"x": [1.0]}, client)


def test_a_module_that_workers_lack_is_named(client, tmp_path, monkeypatch):
    (tmp_path / "only_here.py").write_text("def function(x):\n    return x\n")
    monkeypatch.syspath_prepend(tmp_path)
    from only_here import function

    with pytest.raises(SweepError, match="No module named 'only_here'.*must be installed there"):
        sweep(function, {"x": [1.0]}, client)


def test_what_is_no_usable_client_is_refused(client):
    with pytest.raises(TypeError, match=r"is a dask.distributed.Client, not str"):
        sweep(drawn, GRID, "tcp://127.0.0.1:8786")
    with pytest.raises(ValueError, match="workers is for threads without a client"):
        sweep(drawn, GRID, client, workers=2)
    with pytest.raises(ValueError, match="a timeout is a positive number of seconds, not 0"):
        sweep(drawn, GRID, client, timeout=0)


@pytest.fixture
def own_cluster(tmp_path):
    with cluster(tmp_path, workers=1) as own:
        yield own


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGSTOP])
def test_a_dead_or_silent_scheduler_ends_the_sweep_in_time_and_the_store_goes_on(
    own_cluster, tmp_path, monkeypatch, end
):
    (scheduler, *_), connected = own_cluster
    made = []
    begin = Cluster.__init__
    monkeypatch.setattr(Cluster, "__init__", lambda self, *given: made.append(self) or begin(self, *given))

    def strike(progress):
        if progress.done > 20 and made[0]._timeout > 2.0:
            scheduler.send_signal(end)
            made[0]._timeout = 2.0  # patient with a busy machine before, not with a dead scheduler

    options = {"store": tmp_path / "s", "block_points": 6, "outputs": {"y": "m"}}
    with pytest.raises(ClusterLost, match="does not answer for 2 s: start it again|is closed: make a new one"):
        sweep(only_y, GRID, connected, progress=strike, timeout=600, **options)
    scheduler.send_signal(signal.SIGCONT)
    before = (tmp_path / "s" / "_done").read_text().splitlines()
    assert 3 <= len(before) < 20
    assert_array_equal(sweep(only_y, GRID, **options)["y"], sweep(only_y, GRID)["y"])


def only_y(x, rng):
    time.sleep(0.002)
    return {"y": x * rng.standard_normal()}


def test_no_workers_is_an_error_in_time(tmp_path):
    with (
        distributed.LocalCluster(
            n_workers=0, processes=False, dashboard_address=":0", silence_logs=logging.CRITICAL
        ) as cluster,
        distributed.Client(cluster) as connected,
    ):
        with pytest.raises(ClusterLost, match="has no workers for 3 s"):
            sweep(drawn, GRID, connected, timeout=3.0)
    with pytest.raises(ClusterLost, match="the client of the cluster is closed: make a new one"):
        sweep(drawn, GRID, connected)


def test_the_job_script_for_slurm_asks_for_what_was_asked(tmp_path):
    pytest.importorskip("dask_jobqueue")
    example = Path(__file__).parent.parent / "examples" / "sweep_on_slurm.py"
    shown = subprocess.run(
        [sys.executable, example], capture_output=True, text=True, check=True, timeout=600, cwd=tmp_path
    ).stdout
    lines = shown.splitlines()
    assert lines[0] == "#!/usr/bin/env bash"
    for wanted in (
        "#SBATCH -n 1",
        "#SBATCH --cpus-per-task=32",
        "#SBATCH --mem=60G",
        "#SBATCH -t 04:00:00",
        "#SBATCH -p compute",
        "export OMP_NUM_THREADS=1",
    ):
        assert wanted in lines, shown
    (command,) = [line for line in lines if "worker" in line and not line.startswith("#")]
    assert re.search(r"tcp://\S+:\d+", command), command
    assert "--nthreads 1 " in command, command
    assert "--nworkers 32 " in command, command
    subprocess.run(["bash", "-n"], input=shown, text=True, check=True)
