"""The studies of the report, a file each: what is asked, measured and judged (`validation.report.registered` lists them)."""
