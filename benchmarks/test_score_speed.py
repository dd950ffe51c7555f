"""Time of a score, compared with public implementations, in turn in one run.

``pytest benchmarks/test_score_speed.py -s``

Read the ratios, not the times. The best of several rounds counts, and contenders alternate, so that other load affects
all of them. All use one thread unless stated otherwise.
"""

import time
import tracemalloc
from functools import partial

import numpy as np
import peers

import npss

SHAPES = [(2232, 30, 88), (1000, 100, 99), (300, 400, 156), (8, 100, 99)]
LEAST = 0.02  # seconds in a round


def best(*contenders, turns=7):
    """Return the seconds of a call of each contender: the best of all rounds."""
    seconds = np.full((turns, len(contenders)), np.inf)
    calls = []
    for contender in contenders:
        start = time.perf_counter()
        contender()
        calls.append(int(LEAST / (time.perf_counter() - start)) + 1)
    for turn, (index, contender) in ((t, c) for t in range(turns) for c in enumerate(contenders)):
        start = time.perf_counter()
        for _ in range(calls[index]):
            contender()
        seconds[turn, index] = (time.perf_counter() - start) / calls[index]
    return seconds.min(axis=0)


def motions(*shape):
    gt, pred = np.random.default_rng(0).normal(size=(2, *shape))
    return gt, pred


def scores(*pairs):
    """Return, for each pair, the calls that score it by `released` and `paper`."""
    return [partial(npss.score, *pair, convention=name) for pair in pairs for name in ("released", "paper")]


def rffts(gt, pred):
    return np.fft.rfft(gt, axis=1), np.fft.rfft(pred, axis=1)


def read(gt, pred):
    return gt.sum() + pred.sum()


def test_against_vectorised_code():
    print("\nms (times faster than `fast` of the same convention)")
    print(f"{'N, T, D':14} {'fast released':>13} {'fast paper':>10} {'released':>14} {'paper':>14}", end="")
    print(f" {'released, f4':>14} {'paper, f4':>14} {'both rffts':>10} {'one read':>8}")
    for shape in SHAPES:
        pair = motions(*shape)
        peer = partial(peers.fast, *pair), partial(peers.fast, *pair, real=False)
        ours = scores(pair, [array.astype(np.float32) for array in pair])
        took = 1e3 * best(*peer, *ours, partial(rffts, *pair), partial(read, *pair))
        print(f"{', '.join(map(str, shape)):14} {took[0]:13.1f} {took[1]:10.1f}", end="")
        for index, time_of_ours in enumerate(took[2:6]):
            print(f" {time_of_ours:7.2f} ({took[index % 2] / time_of_ours:4.1f})", end="")
        print(f" {took[6]:10.1f} {took[7]:8.2f}")
        assert abs(ours[0]() - peer[0]()) < 1e-10
        assert abs(ours[1]() - peer[1]()) < 1e-10


def test_against_loops():
    for shape in (100, 30, 88), (100, 100, 99):
        pair = motions(*shape)
        loops, released = best(partial(peers.loops, *pair), scores(pair)[0], turns=3)
        print(f"\n{shape}: {loops / released:.0f} times faster than `loops` (released)")


def test_prime_numbers_of_frames():
    print("\ntime per frame of a prime T, over that of the faster of its neighbours: released, paper")
    for prime in (31, 61, 97, 101, 127, 157, 163, 199, 251):
        below, own, above = (motions(2**21 // 100 // (prime + step), prime + step, 100) for step in (-1, 0, 1))
        took = best(*scores(below, own, above)).reshape(3, 2) / [[below[0].size], [own[0].size], [above[0].size]]
        ratios = took[1] / took[[0, 2]].min(axis=0)
        print(f"{prime:5} {ratios[0]:6.2f} {ratios[1]:6.2f}")


def test_two_threads():
    print("\ntimes faster with two threads than with one: released, paper")
    for shape in SHAPES[:3]:
        calls = scores(motions(*shape))
        took = best(*calls, *(partial(call, workers=2) for call in calls))
        print(f"{', '.join(map(str, shape)):14} {took[0] / took[2]:6.2f} {took[1] / took[3]:6.2f}")


def test_other_inputs():
    gt, pred = motions(1000, 100, 99)
    still = gt.copy(), pred.copy()
    still[0][..., ::2] = still[1][..., ::2] = 0.0
    features_first = [np.ascontiguousarray(a.transpose(0, 2, 1)).transpose(0, 2, 1) for a in (gt, pred)]
    others = {
        "half of the features zero": still,
        "features before frames": features_first,
        "values near 1e200": (gt * 1e200, pred * 1e200),
    }
    took = best(*(partial(npss.score, *pair) for pair in ((gt, pred), *others.values())), turns=3)
    print("\ntime over that of plain values (1000, 100, 99; paper)")
    for name, seconds in zip(others, took[1:], strict=True):
        print(f"{name:26} {seconds / took[0]:5.2f}")


def test_memory():
    print("\nMB of memory beside the input")
    for n, t, d in (10, 100, 99), (10_000, 100, 99), (10_000, 400, 99):
        gt, pred = (np.broadcast_to(a, (n, t, d)) for a in motions(1, t, d))
        peaks = []
        for name in ("released", "paper"):
            tracemalloc.start()
            npss.score(gt, pred, convention=name)
            peaks.append(tracemalloc.get_traced_memory()[1] / 2**20)
            tracemalloc.stop()
        print(f"{n}, {t}, {d}: released {peaks[0]:.1f}, paper {peaks[1]:.1f} (input {2 * gt.size * 8 / 2**20:.0f})")
