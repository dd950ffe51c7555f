"""Reference predictors and models for human motion prediction, and the data they run on."""
