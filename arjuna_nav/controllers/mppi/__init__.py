"""MPPI: noisy controls rolled out, weighed by critics, averaged."""
