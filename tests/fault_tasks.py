"""What other processes do in the tests of faults; light, since each of them imports it."""

import os
import signal
import time

import numpy as np

from semianalytic.results.interface_history import InterfaceHistory


def history():
    """Always the same, of 64 kB."""
    values = np.random.default_rng(1).normal(size=(5, 40, 50))
    return InterfaceHistory(np.linspace(0, 1, 50), np.linspace(0, 1, 40), *values)


def say_and_sleep(seconds):
    print(f"{os.getpid()}\n", end="", flush=True)  # in one piece, beside another process
    time.sleep(seconds)


def kill_me():
    os.kill(os.getpid(), signal.SIGKILL)
