"""Compares the models: convergence, cost, claims, studies, the report and the command line. Imports the other packages."""
