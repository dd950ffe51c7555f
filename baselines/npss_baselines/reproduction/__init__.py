"""The reference numbers: a plan of runs, their records, and tables made from records alone."""
