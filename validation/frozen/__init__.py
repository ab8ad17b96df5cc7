"""The frozen benchmark (docs/benchmark.md): values with certified error bars, their computation, and the comparison of others'
values."""
