"""The metrics themselves: NPSS and the Euler error, their conventions and signatures."""
