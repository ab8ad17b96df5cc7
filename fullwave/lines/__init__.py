"""The method of lines: the semi-discrete equations of motion that SBP, elements and DG share, and their march."""
