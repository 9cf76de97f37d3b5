"""How much faster a filter over batches of runs is than the same filter stepped run by run, in credence.study.

PYTHONPATH=build/release/python:tests/python python3 bench/numpy_batches.py [RUNS STEPS [TIMES]]
"""

import sys
import time

import credence

from plugs import Filter, World


def seconds(batch, runs, steps):
    """Wall time and processor time of a study."""
    wall, processor = time.perf_counter(), time.process_time()
    credence.study(World(), Filter, runs=runs, steps=steps, batch=batch)
    return time.perf_counter() - wall, time.process_time() - processor


def main():
    runs, steps, times = [*map(int, sys.argv[1:]), *(640, 50, 5)[len(sys.argv) - 1:]]
    seconds(True, 64, 5)
    for _ in range(times):  # interleaved, as the machine may be busy
        batches, single = seconds(True, runs, steps), seconds(False, runs, steps)
        print(f"{runs} runs of {steps} steps: batches {batches[0]:.3f} s, run by run {single[0]:.2f} s, "
              f"ratio {single[0] / batches[0]:.1f}, of processor time {single[1] / batches[1]:.1f}")


if __name__ == "__main__":
    main()
