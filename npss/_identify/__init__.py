"""Which NPSS does a function compute? Run it on probes, and compare its values with all choices."""
