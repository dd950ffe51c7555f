"""The metrics: NPSS and the Euler error, their conventions and signatures."""
