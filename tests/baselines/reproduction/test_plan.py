"""The plan: what it runs, in which order, and what it refuses."""

import itertools

import pytest

from npss.predictors import PREDICTORS
from npss_baselines.data import pose_sources
from npss_baselines.models import MODELS
from npss_baselines.reproduction.job import configuration_of
from npss_baselines.reproduction.plan import read_plan

ACTIONS = ("walking", "eating", "smoking")
H36M, SYNTHETIC = (pose_sources()[name] for name in ("h36m", "synthetic"))
PLAN = read_plan()
SMALL = """
[recipes.untrained]
what = "not trained"
[rows.still]
model = "zero-velocity"
recipe = "untrained"
tables = ["table-4"]
[[order]]
why = "a baseline"
rows = ["still"]
actions = ["walking"]
seeds = [0]
budget = "full"
"""


def names(**options):
    return [run.name for run in PLAN.runs(H36M, **options)]


def of(rows, seeds, actions=ACTIONS):
    return {f"{row}/{action}-seed-{seed}" for row, action, seed in itertools.product(rows, actions, seeds)}


def test_every_run_that_the_page_needs_is_in_the_plan():
    models = ("vgru-d", "gru-d", "vgru-ac", "vgru-r1", "mbr-long", "mbr-unsup")
    ablation = ("no-top-rnn", "no-derivatives", "open-loop", "sampling", "noise", "vgru-ac")
    needed = (
        of(PREDICTORS, [0])
        | of(("ridge", "nearest-10"), [0])
        | of(models, [0, 1, 2])
        | of(ablation, [0, 1, 2], ["walking"])
    )
    needed |= of(("erd", "lstm-3lr", "srnn"), [0]) | {"vgru-d-faithful/walking-seed-0"}
    needed |= of(("dc-share", "calibrated-blend"), [0, 1, 2], ["3-actions"]) | {"dc-share-median/3-actions-seed-0"}
    needed |= {f"{row}/15-actions-seed-0" for row in ("vgru-r1-all", "mbr-unsup-all", "mbr-sup-all")}
    assert needed <= set(names())


def test_runs_are_in_order_of_worth_and_none_is_a_duplicate():
    runs = names()
    assert len(set(runs)) == len(runs)
    assert runs.index("zero-velocity/walking-seed-0") < runs.index("vgru-d/walking-seed-0")
    assert runs.index("vgru-d/smoking-seed-0") < runs.index("vgru-d/walking-seed-1")


def test_an_hour_buys_the_first_runs_and_minutes_a_trial_of_its_own():
    hours, full = names(budget="hours"), names(budget="full")
    assert hours == full[: len(hours)]
    assert len(hours) < len(full)
    for run in PLAN.runs(H36M, budget="minutes"):
        assert run.row.iterations in (None, 3)


def test_rows_keep_to_the_time_that_their_recipe_promises():
    most = {"untrained": 1, "fitted": 10, "ours": 15, "reduced": 30, "all-actions": 30, "faithful": 70}
    assert all(row.minutes <= most[row.recipe] for row in PLAN.rows.values())
    assert set(PLAN.recipes) <= set(most)


@pytest.mark.parametrize(
    ("only", "chosen"),
    [
        ("table-6", {row.name for row in PLAN.rows.values() if "table-6" in row.tables}),
        ("vgru-d", {"vgru-d"}),  # not the other rows of this model, such as the ablation
        ("mbr-unsup-all", {"mbr-unsup-all"}),
        ("mbr-sup", {"mbr-sup-all"}),  # a model that is no row
    ],
)
def test_only_chooses_tables_rows_and_models(only, chosen):
    runs = PLAN.runs(H36M)
    assert PLAN.runs(H36M, only=[only]) == [run for run in runs if run.row.name in chosen]
    assert {run.row.name for run in runs} >= chosen


def test_only_chooses_runs():
    chosen = ["vgru-d/walking-seed-0", "erd/eating-seed-0"]
    assert [run.name for run in PLAN.runs(H36M, only=chosen)] == chosen


def test_only_refuses_what_is_not_in_the_plan():
    with pytest.raises(ValueError, match=r"^only: .*'vgru'"):
        PLAN.runs(H36M, only=["vgru"])


def test_only_says_when_the_budget_leaves_nothing():
    for name in ("erd", "erd/eating-seed-0"):
        with pytest.raises(ValueError, match=rf"^only: the plan has no run of {name} within the budget 'hours'"):
            PLAN.runs(H36M, only=[name], budget="hours")


def test_an_unknown_action_is_refused_unless_the_source_has_none_of_the_plan(tmp_path):
    file = tmp_path / "plan.toml"
    other = SMALL[SMALL.index("[[order]]") :].replace("walking", "wlaking")
    file.write_text(SMALL + other, encoding="utf-8")
    with pytest.raises(ValueError, match=r"^order: actions: h36m has none of wlaking"):
        read_plan(file).runs(H36M)
    assert [run.name for run in read_plan(file).runs(SYNTHETIC)] == ["still/gait-seed-0"]


def test_subjects_are_those_with_recordings_of_all_actions():
    by_name = {run.name: run for run in PLAN.runs(H36M)}
    assert by_name["vgru-d/walking-seed-0"].subjects == (1, 6, 7, 8, 9, 11)
    assert by_name["vgru-d/smoking-seed-0"].subjects == (1, 6, 8, 11)
    assert by_name["mbr-sup-all/15-actions-seed-0"].subjects == (1, 6, 8, 11)


def test_another_source_trains_on_its_own_action():
    runs = PLAN.runs(SYNTHETIC, budget="hours")
    assert {run.actions for run in runs} == {("gait",)}
    assert len({run.name for run in runs}) == len(runs)


def test_settings_change_the_configuration_and_nothing_else_does():
    by_name = {run.name: run for run in PLAN.runs(H36M)}
    for run in by_name.values():
        if run.row.model in MODELS:
            configuration = configuration_of(run, H36M)
            assert configuration.recipe.iterations == run.row.iterations
            assert configuration.seed == run.seed
            assert configuration.actions == run.actions
    ours, faithful = (configuration_of(by_name[f"{row}/walking-seed-0"], H36M) for row in ("vgru-d", "vgru-d-faithful"))
    assert (ours.recipe.optimizer, ours.average, ours.select) == ("adam", 0.99, "last")
    assert faithful.recipe == MODELS["vgru-d"].recipe.compressed(2000)
    assert faithful.average is None
    assert faithful.select == "last"
    assert not configuration_of(by_name["no-top-rnn/walking-seed-0"], H36M).model.top_rnn
    assert configuration_of(by_name["no-derivatives/walking-seed-0"], H36M).model.n_derivatives == 0
    for row in ("open-loop", "sampling", "noise"):
        regime = configuration_of(by_name[f"{row}/walking-seed-0"], H36M).recipe.regime
        assert regime == row.removesuffix("-loop")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('recipe = "untrained"', 'recipe = "trained"', r"rows\.still: recipe"),
        ('model = "zero-velocity"', "", r"rows\.still: missing model"),
        ('model = "zero-velocity"', 'model = "zero"', r"rows\.still: model: .*'zero'"),
        ('tables = ["table-4"]', 'tables = ["table-4"]\nseed = 1', r"rows\.still: unknown seed"),
        ('rows = ["still"]', 'rows = ["moving"]', r"order\[0\]: rows"),
        ("seeds = [0]", "seeds = [-1]", "seed"),
        ('budget = "full"', 'budget = "days"', r"order\[0\]: budget"),
        ("[[order]]", "[order]", "order: expected a list of tables"),
        ('tables = ["table-4"]', 'tables = "table-4"', r"rows\.still: tables: expected a sequence of names"),
        ('tables = ["table-4"]', 'tables = ["table-4"]\nminutes = "7"', r"rows\.still: minutes"),
        ('tables = ["table-4"]', 'tables = ["table-4"]\niterations = 1.5', r"rows\.still: iterations"),
        ('tables = ["table-4"]', 'tables = ["table-4"]\nsettings = 3', r"rows\.still: settings: expected a table"),
        ('actions = ["walking"]', 'actions = "walking"', r"order\[0\]: actions: expected a sequence of names"),
        ("[recipes.untrained]\nwhat", "recipes = 3\n[other]\nwhat", "unknown other|recipes: expected a table"),
        ("[rows.still]", "[rows.still", "plan.toml"),
    ],
)
def test_a_broken_plan_is_refused_by_file_and_place(tmp_path, old, new, message):
    file = tmp_path / "plan.toml"
    file.write_text(SMALL, encoding="utf-8")
    assert len(read_plan(file).runs(H36M)) == 1
    file.write_text(SMALL.replace(old, new), encoding="utf-8")
    with pytest.raises(ValueError, match=message) as caught:
        read_plan(file)
    assert str(caught.value).startswith(str(file))
