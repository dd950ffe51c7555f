"""Motion to predict: Human3.6M where a user has it, and a generated gait that needs no data."""
