"""Random tests repeat the same examples in every run; `pytest --hypothesis-profile=explore` looks for new ones."""

from hypothesis import HealthCheck, settings

# no deadline: the first call may compile
_COMMON = {"deadline": None, "print_blob": True, "suppress_health_check": [HealthCheck.too_slow]}

settings.register_profile("repeatable", derandomize=True, max_examples=200, **_COMMON)
settings.register_profile("explore", max_examples=3000, **_COMMON)
settings.load_profile("repeatable")
