"""The folder of a trained model, and what every training does with it."""
