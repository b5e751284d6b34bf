"""Ctrl-C is heard within 0.2 s in every call that can take long, also while earlier, interrupted work still ends."""

import subprocess
import sys

CALLS = '''
import os, signal, sys, threading, time
import numpy as np
from fractional_haptics import analysis, control, experiment, operators, sweep, tissue

HEARD_S = 0.2
T = 1e-3
device = analysis.Device(0.065, 3.5)
zener = tissue.Model("zener", elastic_modulus_pa=1e3, second_elastic_modulus_pa=2e3, viscosity_pa_s=500.0)
muscle = tissue.find("fish-muscle").model
t = np.geomspace(0.02, 900, 300)
modulus = muscle.relaxation_modulus(t) * (1 + 0.01 * np.random.default_rng(1).standard_normal(300))
lag = control.plant("1/(s+1)")
pid = control.Pid(0.01, proportional=1.0, integral=1.0, integral_order=0.9)
full = operators.Operator(0.5, T)
late = operators.Operator(0.5, T, "grunwald:100000")
loop = analysis.Loop(device, 1000.0, 3.0, 0.5, T, "grunwald:5000")
long = np.zeros(5_000_000)
omega = np.linspace(1.0, 3000.0, 200_000)

# Identification, design and Z-width twice: what runs on all cores must not stand in the way of what comes after it.
CALLS = {
    "identify": lambda: tissue.identify(t, modulus, bootstrap=100_000),
    "zwidth": lambda: experiment.zwidth(points=1000),
    "identify again": lambda: tissue.identify(t, modulus, bootstrap=100_000),
    "design": lambda: experiment.design(orders=np.linspace(0.0, 2.0, 2000)),
    "zwidth again": lambda: experiment.zwidth(points=1000),
    "relax": lambda: experiment.relax(tissue="prostate-healthy", duration_s=20_000.0),
    "process": lambda: operators.Operator(0.5, T, "grunwald:2000").process(long),
    "weights": lambda: full.weights(100_000_000),
    "frequency_response": lambda: late.frequency_response(omega),
    "loop_gain": lambda: loop.loop_gain(omega),
    "transparency": lambda: analysis.transparency(device, 500.0, 1.0, 0.5, T, omega, "grunwald:5000"),
    "simulate": lambda: control.simulate(lag, pid, reference=long[:2_000_000]),
    "step_response": lambda: control.TransferFunction("1/(s^0.5+1)").step_response(T, 5_000_000),
    "differintegrate": lambda: operators.differintegrate(np.zeros((20, 500_000)), 0.5, T),
    "stress": lambda: muscle.stress(np.arange(40_000) * T, np.ones(40_000)),
    "region": lambda: analysis.region(device, 0.5, T, points=10_000_000),
    "sweep": lambda: sweep.sweep(lambda x: time.sleep(60.0) or 0.0, {"x": range(9)}, outputs={"value": "1"}, block_points=1),
}


def waited(call):
    """Time from the signal to the exception, s; infinite where the call ended before."""
    sent = []

    def interrupt():
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.15, interrupt)
    timer.start()
    try:
        call()
        timer.join()
        time.sleep(0.1)
    except KeyboardInterrupt:
        if sent:
            return time.perf_counter() - sent[0]
    return float("inf")


for name, call in CALLS.items():
    # The machine may be busy with other things once or twice.
    tries = (waited(call) for _ in range(3))
    print(name, next((seconds for seconds in tries if seconds < HEARD_S), "not heard"), sep=":", flush=True)
print("all")
os._exit(0)
'''


def test_ctrl_c_is_heard_in_every_call() -> None:
    ran = subprocess.run([sys.executable, "-c", CALLS], capture_output=True, text=True, timeout=600, check=False)
    assert ran.stdout.endswith("all\n"), ran.stdout + ran.stderr
    assert "not heard" not in ran.stdout, ran.stdout


def test_an_interrupted_block_leaves_the_operator_as_it_was() -> None:
    code = """
import _thread, threading
import numpy as np
from fractional_haptics.operators import Operator
operator, beside = Operator(0.5, 1e-3), Operator(0.5, 1e-3)
operator.process(np.ones(100))
beside.process(np.ones(100))
threading.Timer(0.3, _thread.interrupt_main).start()
try:
    operator.process(np.ones(50_000_000))
except KeyboardInterrupt:
    print(operator.step(2.0) == beside.step(2.0))
"""
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=True)
    assert ran.stdout.strip() == "True", ran.stderr
