"""Compares: convergence, run time against error, claims, studies, the report and the command line. Imports the other rooms."""
