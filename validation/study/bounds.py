"""The former name of `validation.study.claim`."""

from validation.study import claim as bounded

__all__ = ["bounded"]
