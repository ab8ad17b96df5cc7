"""The method of lines: semi-discrete equations of motion, written once for SBP, elements and DG, and their march."""
