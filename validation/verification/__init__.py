"""`slipwave verify`: a scheme, a law or a scene judged by the rows by which the report judges ours."""
