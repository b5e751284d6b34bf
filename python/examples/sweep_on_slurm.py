"""A sweep on a cluster with Slurm: jobs of 32 processes each, started by dask-jobqueue.

    python sweep_on_slurm.py                # prints the job script, on any machine
    python sweep_on_slurm.py --jobs 30      # on the login node of the cluster

Needs ``pip install 'fractional-haptics[sweep]' dask-jobqueue`` on the login node and on all others, which share it as a
rule. Stop it by Ctrl-C and start it again: what is done stays done.
"""

import argparse

import numpy as np
from dask_jobqueue import SLURMCluster
from dask_jobqueue.slurm import SLURMJob
from distributed import Client

from fractional_haptics.operators import grunwald_weights
from fractional_haptics.sweep import Grid, Output, axis, sweep


def remembered(order: float, samples: int) -> float:
    """Share of a step that the `samples` newest samples of history leave out."""
    return abs(float(np.sum(grunwald_weights(order, samples))))


# A job of 32 processes with one thread each.
JOB = {
    "queue": "compute",
    "cores": 32,
    "processes": 32,
    "memory": "64 GB",
    "walltime": "04:00:00",
    "job_script_prologue": ["export OMP_NUM_THREADS=1"],
}


def main() -> None:
    """Prints the job script, or runs the sweep."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, help="Slurm jobs to start; without it the job script is printed")
    arguments = parser.parse_args()
    if arguments.jobs is None:
        # A script needs no scheduler, and no thread that has to end again.
        print(SLURMJob("tcp://LOGIN-NODE:8786", name="fractional-haptics", **JOB).job_script())
        return
    with SLURMCluster(scheduler_options={"dashboard_address": ":0"}, **JOB) as jobs:
        jobs.scale(jobs=arguments.jobs)
        grid = Grid(
            order=axis(np.linspace(0.05, 0.95, 181), about="order"),
            samples=axis(np.unique(np.geomspace(10, 1e6, 400).astype(int)), about="samples of history"),
        )
        with Client(jobs) as client:
            # An hour in the queue is no reason to give up.
            result = sweep(remembered, grid, client, "remembered.zarr", outputs={"value": Output()}, timeout=3600)
        print(result)


if __name__ == "__main__":
    main()
