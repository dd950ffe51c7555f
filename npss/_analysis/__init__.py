"""What a score tells: reports, comparisons, intervals, tests, pitfalls."""
