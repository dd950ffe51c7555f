"""The reference numbers: a plan of runs, their records, and tables made from records alone."""

#: How much of the plan to run. Minutes: every step on a small scale, for a trial. Hours: one seed of each model.
BUDGETS = ("minutes", "hours", "full")
