"""Runs the geometry compensation of the package bladesight on edge times and writes the error of every edge.

Diamond, Heyns, Oberholster, "Online shaft encoder geometry compensation for arbitrary shaft speed profiles using Bayesian
regression", Mechanical Systems and Signal Processing 81 (2016), doi 10.1016/j.ymssp.2016.02.060.

Turns are shared out among as few blocks as the package can hold at once; the blocks' results are averaged by turns. Output is one
line a precision: beta, seconds that the package took, then e(k) in rad for every edge of a turn.
"""

import argparse
import csv
import time

import numpy as np
from bladesight.ias.geometry_compensation import perform_bayesian_geometry_compensation


def edge_errors(sections):
    """e(k), zero mean, from the angles between neighbouring edges: section k goes from edge k to edge k + 1."""
    steps = 2.0 * np.pi / len(sections) - sections
    errors = np.concatenate(([0.0], np.cumsum(steps)[:-1]))
    return errors - errors.mean()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("times", help="one tick count a line, the first of an edge 0")
    parser.add_argument("out")
    parser.add_argument("--clock-hz", type=float, required=True)
    parser.add_argument("--edges", type=int, required=True, help="edges a turn")
    parser.add_argument("--block", type=int, required=True, help="most turns that are solved at once")
    parser.add_argument("--beta", type=float, nargs="+", required=True, help="precision of the likelihood")
    parser.add_argument("--sigma", type=float, required=True)
    options = parser.parse_args()
    ticks = np.loadtxt(options.times, dtype=np.int64)
    edges = options.edges
    turns = (len(ticks) - 1) // edges
    blocks = -(-turns // options.block)
    starts = [turns * block // blocks for block in range(blocks + 1)]
    with open(options.out, "w", newline="") as file:
        writer = csv.writer(file)
        for beta in options.beta:
            errors = np.zeros(edges)
            start = time.perf_counter()
            for first, end in zip(starts, starts[1:]):
                part = ticks[first * edges : end * edges + 1]
                sections = perform_bayesian_geometry_compensation(
                    (part - part[0]) / options.clock_hz,
                    N=edges,
                    M=end - first,
                    beta=beta,
                    sigma=options.sigma,
                )
                errors += edge_errors(np.asarray(sections)) * (end - first) / turns
            seconds = time.perf_counter() - start
            writer.writerow([repr(beta), repr(seconds), *(repr(float(e)) for e in errors)])
            file.flush()


if __name__ == "__main__":
    main()
