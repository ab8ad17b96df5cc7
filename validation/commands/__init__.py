"""The commands of `slipwave`, one per file. Each imports what it needs only when it runs, so that `--help` stays quick."""
