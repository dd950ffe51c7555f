"""Tests of the distance G as a metric of leaderboards."""

from dataclasses import replace

import numpy as np
import pytest
import torch

import npss
from npss.metrics import register
from npss.ranking._submissions import records_of
from npss_baselines.__main__ import main
from npss_baselines.commands.leaderboard import submit
from npss_baselines.data.motion import Clip, joints_of_poses
from npss_baselines.data.synthetic import synthetic_task
from npss_baselines.manifold.applications.distance import metric_of
from npss_baselines.manifold.model.autoencoder import Autoencoder, AutoencoderConfig
from npss_baselines.manifold.motion.dataset import prepare
from npss_baselines.manifold.motion.prepared import motion_set
from npss_baselines.manifold.motion.scaling import fit_scaling
from npss_baselines.manifold.training import folder
from npss_baselines.manifold.training.config import FILE, defaults, write

pytestmark = pytest.mark.usefixtures("registry")
MODELS = ["zero-velocity", "repeat-50"]


@pytest.fixture(scope="module")
def manifold(tmp_path_factory):
    """Return the folder of an untrained run."""
    torch.manual_seed(0)
    motions = motion_set(quick=True)
    configuration = replace(defaults(), model=AutoencoderConfig(widths=(12, 10), kernel=5))
    run = tmp_path_factory.mktemp("manifold")
    write(run / FILE, configuration, "cpu")
    statistics = fit_scaling(motions.windows, motions.mask, "kind")
    folder.save(run, Autoencoder(configuration.model), statistics, {})
    return run


def test_g_of_each_model(manifold):
    task = synthetic_task(4)
    submissions = submit(MODELS, [task])
    projector = folder.load(manifold).projector
    register(metric_of(projector), replace=True)
    records = records_of(submissions, metrics=["G"], protocol=task.protocol)
    for record in records:
        codes = []
        for poses in (task.target, submissions[record["model"]]["gait"].pred):
            still = np.array(poses)
            still[..., :6] = 0  # the root stays, and faces ahead
            clips = [Clip(str(i), "poses", "", "", 25, joints_of_poses(motion)) for i, motion in enumerate(still)]
            codes.append(projector.encode(np.stack(prepare(clips).features)).astype(float))
        gt, pred = codes
        expected = sum(((extreme(gt, axis=1) - extreme(pred, axis=1)) ** 2).sum(axis=1) for extreme in (np.max, np.min))
        np.testing.assert_allclose(record["sequences"]["metrics"]["G"], expected, rtol=1e-9)
        assert record["metrics"]["G"] == pytest.approx(expected.mean())
        fields = npss.parse_signature(record["signatures"]["G"])
        assert fields["manifold"] == projector.signature
        assert (fields["metric"], fields["frames"], fields["protocol"]) == ("g", 100, "synthetic-4")


def test_column_and_signature(capsys, manifold):
    assert main(["leaderboard", *MODELS, "--synthetic", "--metrics", "G", "--manifold", str(manifold)]) == 0
    printed = capsys.readouterr().out
    assert "G" in next(line for line in printed.splitlines() if line.startswith("rank")).split()
    assert "g|version:1|frames:100|fps:25|protocol:synthetic-64|manifold:" in printed


def test_explain(manifold):
    register(metric_of(folder.load(manifold).projector), replace=True)
    assert npss.explain("g|version:1").startswith("G: the squared distance of the extremes over time")


@pytest.mark.parametrize("options", [["--metrics", "G"], ["--metrics", "mse", "g"], ["--manifold", "RUN"]])
def test_missing_manifold(capsys, options):
    assert main(["leaderboard", *MODELS, "--synthetic", *options]) == 2
    assert "--manifold RUN: the manifold for --metrics G" in capsys.readouterr().err
