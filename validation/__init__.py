"""The instrument (models, commands, data, fit, sweep, chart, references), and its proof, which uses it as any user does (measure,
verification, studies, report). Imports the other packages."""
