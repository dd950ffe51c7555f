"""Threads: the same bits, the same errors, and the requested number."""

import concurrent.futures
import os

import numpy as np
import pytest
from hypothesis import given

import npss
from npss._metric import kernel as _kernel
from npss._metric.score import n_workers, weighted_sums
from strategies import pairs


@pytest.fixture
def small_blocks(monkeypatch):
    """Make blocks small, so that tests have many."""
    monkeypatch.setattr(_kernel, "_BLOCK", 1)
    monkeypatch.setattr(_kernel, "_BLOCK_COLUMNS", 1)


@pytest.mark.parametrize("name", npss.CONVENTIONS)
@pytest.mark.parametrize("workers", [2, 3, -1, 1000])
def test_the_bits_do_not_depend_on_the_number_of_threads(small_blocks, name, workers):
    gt, pred = np.random.default_rng(0).normal(size=(2, 40, 30, 5)).cumsum(axis=2)
    assert npss.score(gt, pred, convention=name, workers=workers) == npss.score(gt, pred, convention=name)
    windows = npss.score_windows(gt, pred, fps=10, edges_ms=(0, 1000, 3000), convention=name)
    assert npss.score_windows(gt, pred, fps=10, edges_ms=(0, 1000, 3000), convention=name, workers=workers) == windows


def test_no_thread_is_started_by_default(small_blocks, monkeypatch):
    def refuse(self, *arguments, **options):
        raise AssertionError("a pool of threads")

    gt, pred = np.random.default_rng(0).normal(size=(2, 4, 30, 5))
    monkeypatch.setattr(concurrent.futures.ThreadPoolExecutor, "__init__", refuse)
    npss.score(gt, pred)
    npss.score_windows(gt, pred, fps=10, edges_ms=(0, 1000, 3000))
    npss.Accumulator().update(gt, pred)
    with pytest.raises(AssertionError, match="a pool of threads"):
        npss.score(gt, pred, workers=2)


@pytest.mark.parametrize("workers", [1, 2])
def test_progress_is_reported_after_every_block(small_blocks, workers):
    gt, pred = np.random.default_rng(0).normal(size=(2, 2, 30, 24))
    assert len(_kernel.blocks(gt)) == 2 * 24
    shares = []
    weighted_sums(gt, pred, npss.Convention(), workers=workers, progress=shares.append)
    assert shares == [done / 48 for done in range(1, 49)]


@given(pair=pairs(max_n=6))
def test_the_bits_do_not_depend_on_the_size_of_blocks(pair):
    whole = npss.score(*pair)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_kernel, "_BLOCK_COLUMNS", 2)
        assert npss.score(*pair) == whole
        assert npss.score(*pair, workers=2) == whole


def test_errors_reach_the_caller(small_blocks):
    gt = np.random.default_rng(0).normal(size=(40, 30, 5))
    bad = gt.copy()
    bad[7, 20, 3] = bad[30, 1, 1] = np.nan
    with pytest.raises(ValueError, match=r"pred: nan at index \(7, 20, 3\)"):
        npss.score(gt, bad, workers=2)


@pytest.mark.parametrize("workers", [1.0, "2", None, True])
def test_invalid_numbers_of_threads(workers):
    with pytest.raises(TypeError, match="workers: expected a whole number"):
        npss.score(np.eye(3), np.eye(3), workers=workers)


def test_negative_numbers_count_from_all_cpus(monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 8)
    assert [n_workers(workers) for workers in (1, 5, 20, -1, -8, np.int64(2))] == [1, 5, 20, 8, 1, 2]
    for workers in (0, -9):
        with pytest.raises(ValueError, match=r"workers: expected a positive number, or -1 .* to -8"):
            n_workers(workers)
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert n_workers(-1) == 1
