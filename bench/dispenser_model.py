#!/usr/bin/env python3
"""A model of the ranks of mpirun: how efficient is one writer, and from which number of ranks on is it the limit?

A discrete-event simulation of what montecarlo/engine/shared_tasks.cpp does. Rank 0 gives out guided ranges of
chunks and writes every record, one after the other; a message takes its latency; a helper asks for more when it
begins its last chunk; chunk times are lognormal, and some ranks are slow. Efficiency: the time of all chunks on
as many ranks that never wait, over the time it took. All times in seconds; the defaults are measured ones
(docs/scale.md).

usage: dispenser_model.py [--chunk S] [--write S] [--ask S] [--latency S] [--slow SHARE] [--ranks N,N,...]
                          [--chunks-per-rank N] [--writers N]
"""
import argparse
import heapq
import math
import random

MOST_AHEAD = 4096  # SharedTasks::most_ahead


def simulate(ranks, chunks, o, seed=1):
    """Seconds until all chunks are written, and the share of them that the writer worked."""
    draw = random.Random(seed)
    speed = [2.0 if draw.random() < o.slow else 1.0 for _ in range(ranks)]
    spread = 0.1
    left, given = chunks, 0
    waiting = [0] * ranks  # chunks that a rank has and has not begun
    asked, idle = [True] * ranks, [True] * ranks
    sent = [0] * ranks  # the range that is on its way to it
    events = [(0.0, i, "ask", i) for i in range(ranks)]
    order = ranks
    free = [0.0] * o.writers  # each writer serves its share of the ranks
    busy = 0.0

    def push(time, what, rank):
        nonlocal order
        heapq.heappush(events, (time, order, what, rank))
        order += 1

    def begin(time, rank):
        waiting[rank] -= 1
        if waiting[rank] == 0 and not asked[rank]:
            asked[rank] = True
            push(time + o.latency, "ask", rank)
        mean = o.chunk * speed[rank]
        push(time + mean * draw.lognormvariate(-spread * spread / 2, spread), "done", rank)

    end = 0.0
    while events:
        time, _, what, rank = heapq.heappop(events)
        w = rank % o.writers
        if what == "ask":
            free[w] = max(free[w], time) + o.ask
            size = max(1, min(left // (4 * ranks), MOST_AHEAD // ranks))
            size = min(size, left)
            left -= size
            if size:
                sent[rank] = size
                push(free[w] + o.latency, "range", rank)
        elif what == "range":
            asked[rank] = False
            waiting[rank] += sent[rank]
            if idle[rank]:
                idle[rank] = False
                begin(time, rank)
        elif what == "done":
            push(time + o.latency, "record", rank)
            if waiting[rank]:
                begin(time, rank)
            else:
                idle[rank] = True
        else:
            free[w] = max(free[w], time) + o.write
            busy += o.write
            end = max(end, free[w])
    return end, busy / o.writers / end


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--chunk", type=float, default=0.168, help="of one core")
    parser.add_argument("--write", type=float, default=162e-6, help="of a record")
    parser.add_argument("--ask", type=float, default=20e-6, help="of the answer to a request")
    parser.add_argument("--latency", type=float, default=1e-3, help="of a message")
    parser.add_argument("--slow", type=float, default=0.01, help="share of ranks of half the speed")
    parser.add_argument("--ranks", default="1,2,8,64,512,1024,4096,10000")
    parser.add_argument("--chunks-per-rank", type=int, default=100)
    parser.add_argument("--writers", type=int, default=1)
    o = parser.parse_args()
    print(f"chunk {o.chunk:g} s, write {o.write:g} s, {o.writers} writer(s), {o.chunks_per_rank} chunks a rank, "
          f"{100 * o.slow:g} % of the ranks slow")
    print(f"one writer is full at {o.chunk / o.write:.0f} ranks")
    print(" ranks   seconds  efficiency  writer busy")
    for ranks in map(int, o.ranks.split(",")):
        chunks = ranks * o.chunks_per_rank
        seconds, busy = simulate(ranks, chunks, o)
        ideal = chunks * o.chunk / ranks
        print(f"{ranks:6d} {seconds:9.2f} {ideal / seconds:11.3f} {busy:12.3f}")


if __name__ == "__main__":
    main()
