"""The frozen benchmark (docs/benchmark.md): values with certified bars, how they are computed again, and how others' compare."""
