"""Planted faults: does the test suite notice when the program is wrong? See docs/planted-faults.md."""
