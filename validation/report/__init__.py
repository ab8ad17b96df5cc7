"""The report: runs the studies whose scene, code or settings changed, stores their results, writes one HTML page."""
